"""A page for every scene: its picture, and each comparison with maps, numbers, and how to repeat it."""

from __future__ import annotations

from ..cases import scene_page
from ..maps import object_swatches
from ..report import Report
from ..words import VERDICTS, truth_sentences
from .page import Page


def pages(report: Report) -> list[Page]:
    scenes = report.results.scenes
    around = zip([None, *scenes[:-1]], scenes, [*scenes[1:], None])
    return [Page(scene_page(scene), "scene.html.j2", {
        "scene": scene,
        "before": before,
        "after": after,
        "picture": report.main_picture(scene),
        "pictures": report.pictures[scene.name],
        "objects": list(zip(scene.objects, scene.surfaces, object_swatches(len(scene.objects)))),
        "cases": report.of_scene(scene),
        "failed": [run for run in report.failed if run.scene == scene.name],
        "truth_sentences": truth_sentences,
        "verdicts": VERDICTS,
    }) for before, scene, after in around]
