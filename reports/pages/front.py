"""The first page: what was found, in a paragraph and three answers; then what differs, what is absent, and all scenes."""

from __future__ import annotations

import math
import statistics
from dataclasses import dataclass

from raytruth.comparisons.results import Series
from raytruth.comparisons.stability.document import FILE as FAILURES

from ..cases import Case, verdict_counts
from ..figures.charts import Axis, Line, chart
from ..text.numbers import parts
from ..text.words import VERDICTS, capital, count, slug
from . import matrix
from .page import Page, Report

MOST_PICTURES = 300  # scenes; more are listed without thumbnails


@dataclass(frozen=True)
class Extreme:
    """The comparison that a number is largest in."""

    case: Case
    value: float


@dataclass(frozen=True)
class RendererRow:
    """One renderer over all scenes."""

    name: str
    title: str
    counts: dict[str, int]
    p99: Extreme | None  # of the comparisons that agree, or differ as expected, and those that differ: all of them
    largest: Extreme | None
    slower: float | None  # times the truth's time, at the median scene


def pages(report: Report) -> list[Page]:
    rows, counts = renderer_rows(report.cases), verdict_counts(report.cases)
    of = {verdict: [case for case in report.cases if case.comparison.verdict == verdict] for verdict in VERDICTS}
    pairs = report.documents.get(matrix.FILE)
    return [Page("index.html", "index.html.j2", {
        "counts": counts,
        "headline": headline(counts, rows),
        "agreeing": worst(of["agrees"]),
        "expected": worst(of["expected"]),
        "differing": worst(of["differs"]),
        "all_literal": all(case.is_literal for case in of["expected"]),
        "renderers": rows,
        "fastest": sorted((row for row in rows if row.slower is not None), key=lambda row: row.slower),
        "speed": speed_chart(report.cases),
        "groups": [(VERDICTS[v], found) for v, found in {
            "differs": of["differs"], "not compared": [case for case in of["not compared"] if case.has_pictures],
            "expected": of["expected"]}.items() if found],  # who has no picture is among the absent
        "heats": matrix.both(pairs) if pairs else None,
        "failures": report.documents.get(FAILURES),
        "studies": [(series, study(series)) for series in report.results.series],
        "scenes": [(scene, report.pictures[scene.name].thumbnail, report.of_scene(scene)) for scene in report.results.scenes],
        "with_pictures": len(report.results.scenes) <= MOST_PICTURES,
    }, nav="Findings")]


def headline(counts: dict[str, int], rows: list[RendererRow]) -> str:
    """Whether all agrees, in one sentence, and who does not; what could not be compared is never counted as agreeing."""
    total, compared = sum(counts.values()), sum(counts.values()) - counts["not compared"]
    wrong = [row for row in rows if row.counts["differs"]]
    if len(wrong) == 1:
        (row,) = wrong
        who = row.title + ("," if "," in row.title else "")
        tried = sum(row.counts.values()) - row.counts["not compared"]
        return f"{who} differs from the truth on {row.counts['differs']} of {count(tried, 'scene')}."
    if wrong:
        who = " and ".join(row.name for row in wrong) if len(wrong) == 2 else f"{len(wrong)} of {len(rows)} renderers"
        return f"{capital(who)} differ from the truth, in {counts['differs']} of {count(total, 'comparison')}."
    if not compared:
        return "Nothing was compared."
    if counts["expected"]:
        return f"{counts['agrees']} of {count(compared, 'comparison')} agree; {counts['expected']} " \
               f"{'differs' if counts['expected'] == 1 else 'differ'} as expected."
    return f"All {count(compared, 'comparison')} agree with the truth."


def worst(cases: list[Case]) -> dict[str, Extreme | None]:
    """Which of the comparisons has the largest 99 % error, and which the largest error of a single pixel."""
    return {name: extreme(cases, metric) for name, metric in (("p99", "color p99"), ("largest", "color max"))}


def extreme(cases: list[Case], metric: str) -> Extreme | None:
    found = [Extreme(case, value) for case in cases if (value := case.comparison.metrics.get(metric)) is not None]
    return max(found, key=lambda e: (math.inf if math.isnan(e.value) else e.value), default=None)


def renderer_rows(cases: list[Case]) -> list[RendererRow]:
    """Every renderer that was held against the truth, the one with most that differs first, then by name."""
    names = sorted({case.test.renderer for case in cases})
    rows = []
    for name in names:
        own = [case for case in cases if case.test.renderer == name]
        times = [case.slower for case in own if case.slower is not None]
        rows.append(RendererRow(name, own[0].test.title, verdict_counts(own), extreme(own, "color p99"),
                                extreme(own, "color max"), statistics.median(times) if times else None))
    return sorted(rows, key=lambda row: -row.counts["differs"])


def speed_chart(cases: list[Case]) -> str | None:
    """Every comparison as a point: its time, as many times the truth's on that scene, and how far it is from it."""
    lines = []
    for name in sorted({case.test.renderer for case in cases}):
        points = sorted((case.slower, error) for case in cases if case.test.renderer == name and case.slower
                        and (error := case.comparison.metrics.get("color p99")) is not None and math.isfinite(error))
        if points:
            lines.append(Line(name, points, len(lines), "apart"))
    every = [point for line in lines for point in line.points]
    if not every:
        return None
    return chart("speed", "Time against error of every comparison", Axis("time, in times the truth’s on the same scene",
                 [x for x, _ in every]), Axis("99 % of all pixels differ by less than", [y for _, y in every]), lines)


def study(series: Series) -> str:
    """One number over a sweep of another, both logarithmic; what has no place there is in the table alone."""
    lines = [Line(label + (f", slope {parts(series.slope[label])}" if label in series.slope else ""),
                  sorted((x, y) for x, y in points if 0 < x < float("inf") and 0 <= y < float("inf")), number)
             for number, (label, points) in enumerate(series.lines.items())]
    shown = [point for line in lines for point in line.points]
    return chart(f"study-{slug(series.id)}", series.title, Axis(series.x_label, [x for x, _ in shown], few=True),
                 Axis(series.y_label, [y for _, y in shown]), lines)
