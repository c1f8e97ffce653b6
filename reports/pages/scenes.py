"""A page for every scene: all renderers side by side, the viewer, and each comparison with its limits and worst pixels."""

from __future__ import annotations

from ..cases import scene_page
from ..text.words import LITERAL, TRUTHS
from .page import Page, Report
from .viewer import objects, viewer


def pages(report: Report) -> list[Page]:
    scenes = report.results.scenes
    around = zip([None, *scenes[:-1]], scenes, [*scenes[1:], None])
    return [Page(scene_page(scene), "scene.html.j2", {
        "scene": scene,
        "before": before,
        "after": after,
        "picture": report.main_picture(scene),
        "pictures": report.pictures[scene.name],
        "objects": objects(scene),
        "cases": report.of_scene(scene),
        "viewer": viewer(report, scene, "../"),
        "TRUTHS": TRUTHS,
        "LITERAL": LITERAL,
    }) for before, scene, after in around]
