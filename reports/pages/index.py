"""The first page: verdicts worst first, failures, how to read them, studies, all scenes."""

from __future__ import annotations

from ..report import Report
from ..words import STATES, TRUTHS, VERDICTS
from .page import Page


def pages(report: Report) -> list[Page]:
    groups = [(words, [case for case in report.cases if case.comparison.verdict == verdict])
              for verdict, words in VERDICTS.items()]
    states = [(sentence, [run for run in report.failed if run.state == state]) for state, sentence in STATES.items()]
    return [Page("index.html", "index.html.j2", {
        "groups": [(words, members) for words, members in groups if members],
        "states": [(sentence, runs) for sentence, runs in states if runs],
        "verdicts": VERDICTS,
        "truths": TRUTHS,
        "scenes": [(scene, report.main_picture(scene), report.of_scene(scene)) for scene in report.results.scenes],
    })]
