"""The pages of speed against accuracy: an overview, and one page a subject, with charts and tables."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

from raytruth.comparisons.bench.document import Clock
from raytruth.comparisons.charting.document import FILE, Chart, Growth, Point, Series, Subject, Times, frontier, read

from ..figures.charts import Axis, Line, chart
from ..text.numbers import parts
from ..text.tables import comma_separated
from ..text.words import count, sentence, slug
from .page import Page, Report, Summary

__all__ = ["FILE", "pages", "read"]

CLOCKS = {"wall": "wall time", "cpu": "processor time"}


@dataclass(frozen=True)
class Entry:
    """A row of the tables."""

    series: Series
    point: Point
    best: bool  # on the frontier of wrong pixels and the picture's time


@dataclass(frozen=True)
class SubjectView:
    subject: Subject
    page: str
    charts: tuple[str, ...]  # the first one stands for all
    entries: tuple[Entry, ...]
    picked: str  # the finding that stands for the subject

    @property
    def table(self) -> str:
        return f"speed/{slug(self.subject.id)}.csv"


@dataclass(frozen=True)
class Kind:
    """One chart of every subject."""

    id: str
    cost: str  # "picture" or "hits", of which the time counts, or "evaluations"
    error: str  # a field of Accuracy
    label: str
    nothing: str = ""  # the field of Uncertainty up to which an error is none


KINDS = (Kind("hits", "hits", "wrong", "wrong pixels"), Kind("wrong", "picture", "wrong", "wrong pixels"),
         Kind("visible", "picture", "visible", "visibly wrong pixels"),
         Kind("evaluations", "evaluations", "wrong", "wrong pixels"),
         Kind("color", "picture", "color_p99", "error of colour of 99 % of the pixels compared", "color_p99"),
         Kind("largest-color", "picture", "color_max", "largest error of colour", "color_max"),
         Kind("depth", "hits", "depth_p99", "error of depth of 99 % of the pixels that are not wrong", "depth_p99"),
         Kind("largest", "hits", "depth_max", "largest error of depth of a pixel that is not wrong", "depth_max"))


def pages(report: Report) -> list[Page]:
    document = report.documents.get(FILE)
    if document is None:
        return []
    speed = Speed(document)
    summary = Summary(
        "Speed against accuracy",
        "Every first-hit method and every renderer over its own parameter, on "
        f"{count(len(speed.subjects), 'scene or surface', 'scenes and surfaces')}, against proven first hits.",
        sentence(speed.headline), "The charts")
    return [Page("speed.html", "speed.html.j2", {"speed": speed}, nav="Speed", summary=summary,
                 tables={f"growth-{slug(growth.id)}.csv": _growth_table(growth) for growth, _ in speed.growths})] + [
        Page(view.page, "speed_subject.html.j2", {"speed": speed, "view": view}, tables={view.table: _table(view.subject)})
        for view in speed.subjects]


def _table(subject: Subject) -> str:
    """Times in seconds."""
    return comma_separated({"series": s.title, **p.model_dump()} for s in subject.series for p in s.points)


def _growth_table(growth: Growth) -> str:
    return comma_separated({"line": line.label, **p.model_dump()} for line in growth.lines for p in line.points)


class Speed:
    """The whole document, as the pages show it."""

    def __init__(self, document: Chart):
        self.chart = document
        self.clock: Clock = document.clock
        self.time = CLOCKS[self.clock]
        self.subjects = [self._view(subject) for subject in document.subjects]
        self.growths = [(growth, [chart(f"growth-{slug(growth.id)}-{k}", growth.title, *self.growth(growth, k == 1))
                                  for k in (0, 1)]) for growth in document.growths]

    @property
    def headline(self) -> str:
        """The finding of a single subject; of several, none stands for the others."""
        picked = [view for view in self.subjects if view.picked]
        if len(picked) == 1:
            return f"{picked[0].subject.title}: {picked[0].picked}"
        return f"{count(len(picked), 'subject')}, each with a finding of its own" if picked else ""

    @property
    def sweeps(self) -> list[str]:
        """What varies along the lines of the charts, which name the series alone."""
        found = {s.title: [p.label for p in s.points] for subject in self.chart.subjects for s in subject.series}
        return [f"{title}: {labels[0]} to {labels[-1].rpartition(' ')[2]}"
                for title, labels in found.items() if len(labels) > 1]

    def _view(self, subject: Subject) -> SubjectView:
        cost, error = self.cost("picture"), lambda p: p.accuracy and p.accuracy.wrong
        best = frontier((cost(p)[0], error(p)) for s in subject.series if s.kind != "control" for p in s.points
                        if _finite(cost(p), error(p)))
        is_best = lambda p: _finite(cost(p), error(p)) and (cost(p)[0], error(p)) in best
        entries = tuple(Entry(s, p, s.kind != "control" and is_best(p)) for s in subject.series for p in s.points)
        judged = any(p.accuracy for s in subject.series for p in s.points)
        charts = tuple(chart(f"{kind.id}-{slug(subject.id)}", f"{subject.title}: {kind.label}", *self.drawn(subject, kind))
                       for kind in KINDS) if judged else ()
        return SubjectView(subject, f"speed/{slug(subject.id)}.html", charts, entries, next(iter(subject.findings), ""))

    def cost(self, what: str) -> Callable[[Point], tuple[float, float, float] | None]:
        """Of a point: its cost with the least and the most of its turns; milliseconds, or evaluations."""
        def of(point: Point):
            if what == "evaluations":
                return point.evaluations and (point.evaluations,) * 3
            times = getattr(point, what)
            spread = times and getattr(times, self.clock)
            return spread and tuple(1000 * v for v in (spread.median, max(spread.low, spread.median / 1e3), spread.high))
        return of

    def drawn(self, subject: Subject, kind: Kind) -> tuple[Axis, Axis, list[Line], list[tuple[float, float]]]:
        """Axes, lines and frontier of one chart: points that have both numbers; what has no result is in the tables."""
        cost, error = self.cost(kind.cost), lambda p: p.accuracy and getattr(p.accuracy, kind.error)
        nothing = getattr(subject.uncertainty, kind.nothing) if kind.nothing else 0.0
        lines, numbers = [], {}
        for s in subject.series:
            hollow = s.method in numbers  # sweeps of one method share colour and mark; all but the first are hollow
            number = numbers.setdefault(s.method, len(numbers))
            found = [(cost(p), error(p)) for p in s.points if p.state == "ok" and _finite(cost(p), error(p))]
            if found:
                style = "muted" if s.kind == "control" else "hollow" if hollow else "marks"
                lines.append(Line(s.title, [(c[0], e) for c, e in found], number, style, [c[1:] for c, _ in found]))
        best = frontier((x, max(y, nothing)) for line in lines if line.style != "muted" for x, y in line.points)
        what = {"picture": f"{self.time} of a whole picture, ms", "evaluations": "evaluations of f, a camera ray",
                "hits": f"{self.time} of the camera rays’ first hits alone, ms"}[kind.cost]
        points = [point for line in lines for point in line.points]
        label = kind.label if kind.nothing else f"{kind.label} of {parts(subject.pixels)}"
        return (Axis(what, [v for line in lines for ends in line.spread for v in ends]),
                Axis(label, [y for _, y in points], nothing, "rounding" if nothing else "none"), lines, best)

    def growth(self, growth: Growth, second: bool) -> tuple[Axis, Axis, list[Line]]:
        """How time, or what the study has besides, grows. What threads save only the clock on the wall shows."""
        of_threads = growth.id == "threads"
        time: Callable[[Times], float] = lambda t: (t.wall if of_threads else getattr(t, self.clock)).median
        lines = [Line(line.label if len(growth.lines) > 1 else "", [
            (p.x, p.second if second else time(p.picture)) for p in line.points
            if p.state == "ok" and (p.second if second else p.picture) is not None], number)
            for number, line in enumerate(growth.lines)]
        points = [point for line in lines for point in line.points]
        label = growth.second_label if second else f"{CLOCKS['wall'] if of_threads else self.time} of a picture, s"
        return (Axis(growth.x_label, [x for x, _ in points], few=True),
                Axis(label, [y for _, y in points], step=0.25 if second and of_threads else None), lines)

    def faults(self) -> str:
        return count(len(self.chart.faults), "point") + " without a result"


def _finite(cost: tuple[float, ...] | None, error: float | None) -> bool:
    return cost is not None and error is not None and math.isfinite(cost[0]) and cost[0] > 0 and math.isfinite(error)
