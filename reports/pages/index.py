"""The first page: verdicts worst first, failures, how to read them, studies, all scenes."""

from __future__ import annotations

from ..report import Report
from ..words import STATES, TRUTHS, VERDICTS
from .page import Page


def pages(report: Report) -> list[Page]:
    groups = [(words, [case for case in report.cases if case.comparison.verdict == verdict],
               report.tally.silent if verdict == "not compared" else []) for verdict, words in VERDICTS.items()]
    states = [(state, [run for run in report.failed if run.state == state]) for state in STATES]
    return [Page("index.html", "index.html.j2", {
        "groups": [group for group in groups if group[1] or group[2]],
        "titles": {scene.name: scene.title or scene.name for scene in report.results.scenes},
        "states": [(state, runs) for state, runs in states if runs],
        "verdicts": VERDICTS,
        "truths": TRUTHS,
        "scenes": [(scene, report.main_picture(scene), report.of_scene(scene)) for scene in report.results.scenes],
    })]
