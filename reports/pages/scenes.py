"""The first page, and a page for every scene: its picture, each comparison with maps, numbers, and how to repeat it."""

from __future__ import annotations

from comparisons.results import Series

from ..cases import scene_page, verdict_counts
from ..figures.charts import Axis, Line, chart
from ..text.numbers import parts
from ..text.words import LITERAL, TRUTHS, VERDICTS, slug
from .page import Page, Report
from .viewer import objects, viewer


def pages(report: Report) -> list[Page]:
    scenes = report.results.scenes
    groups = [(words, [case for case in report.cases if case.comparison.verdict == verdict])
              for verdict, words in VERDICTS.items()]
    first = Page("index.html", "index.html.j2", {
        "counts": verdict_counts(report.cases),
        "groups": [group for group in groups if group[1]],
        "studies": [(series, study(series)) for series in report.results.series],
        "scenes": [(scene, report.main_picture(scene), report.of_scene(scene)) for scene in scenes],
    })
    around = zip([None, *scenes[:-1]], scenes, [*scenes[1:], None])
    return [first, *(Page(scene_page(scene), "scene.html.j2", {
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
    }) for before, scene, after in around)]


def study(series: Series) -> str:
    """One number over a sweep of another, both logarithmic; what has no place there is in the table alone."""
    lines = [Line(label + (f", slope {parts(series.slope[label])}" if label in series.slope else ""),
                  sorted((x, y) for x, y in points if 0 < x < float("inf") and 0 <= y < float("inf")), number)
             for number, (label, points) in enumerate(series.lines.items())]
    shown = [point for line in lines for point in line.points]
    return chart(f"study-{slug(series.id)}", series.title, Axis(series.x_label, [x for x, _ in shown], few=True),
                 Axis(series.y_label, [y for _, y in shown]), lines)
