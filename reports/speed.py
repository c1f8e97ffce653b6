"""Speed against accuracy: the document's points as charts and tables."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

from comparisons.bench.document import Clock
from comparisons.charting.document import Chart, Growth, Point, Series, Subject, Times, frontier

from .names import slug
from .numbers import parts
from .scatter import Row, Scatter, Style, Value, finite, scatter

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
    main: Scatter | None
    charts: tuple[Scatter, ...]
    entries: tuple[Entry, ...]
    sentences: tuple[str, ...]
    picked: str  # the finding that stands for the subject


class Speed:
    """The whole document, as the pages show it."""

    def __init__(self, chart: Chart):
        self.chart = chart
        self.clock: Clock = chart.clock
        self.styles = _styles(chart)

    @property
    def time(self) -> str:
        return CLOCKS[self.clock]

    @cached_property
    def subjects(self) -> list[SubjectView]:
        return [self._view(subject) for subject in self.chart.subjects]

    @cached_property
    def growths(self) -> list[tuple[Growth, tuple[Scatter, Scatter]]]:
        return [(growth, (self._growth(growth, False), self._growth(growth, True))) for growth in self.chart.growths]

    @cached_property
    def headline(self) -> str:
        """The first finding of the first subject that has one."""
        return next((view.sentences[0] for view in self.subjects if view.sentences), "")

    def _view(self, subject: Subject) -> SubjectView:
        anchor = f"speed-{slug(subject.id)}"
        median = lambda times: times and getattr(times, self.clock)
        picture, hits = (lambda p: median(p.picture)), (lambda p: median(p.hits))
        count = lambda p: p.evaluations
        wrong = lambda p: p.accuracy.wrong
        share = f"wrong pixels of {parts(subject.pixels).text}"
        whole, of_hits = (f"{self.time} of {what}, ms"
                          for what in ("a whole picture", "the camera rays’ first hits alone"))
        u = subject.uncertainty

        def made(kind: str, title: str, x_label: str, y_label: str, cost, error, nothing=0.0, zero="none",
                 alone=False) -> Scatter:
            series = [s for s in subject.series if not alone or s.kind != "converter"]
            return scatter(f"{anchor}-{kind}", f"{subject.title}: {title}", x_label, y_label,
                           self._rows(series, cost, error), nothing=nothing, zero_label=zero)

        if not any(p.accuracy for s in subject.series for p in s.points):
            charts: tuple[Scatter, ...] = ()
        else:
            rounding = "rounding"
            charts = (
                made("wrong", "wrong pixels", whole, share, picture, wrong),
                made("visible", "visibly wrong pixels", whole, f"visibly {share}", picture,
                     lambda p: p.accuracy.visible),
                made("hits", "wrong pixels, first hits alone", of_hits, share, hits, wrong, alone=True),
                made("evaluations", "wrong pixels, evaluations of f", "evaluations of f, a camera ray", share, count,
                     wrong, alone=True),
                made("color", "colour", whole, "error of colour, 99th percentile", picture,
                     lambda p: p.accuracy.color_p99, u.color_p99, rounding),
                made("largest-color", "largest error of colour", whole, "largest error of colour", picture,
                     lambda p: p.accuracy.color_max, u.color_max, rounding),
                made("depth", "depth", whole, "error of depth, 99th percentile", picture,
                     lambda p: p.accuracy.depth_p99, u.depth_p99, rounding),
                made("largest", "largest error of depth", whole, "largest error of depth", picture,
                     lambda p: p.accuracy.depth_max, u.depth_max, rounding))
        best = frontier((picture(p).median, p.accuracy.wrong) for s in subject.series if s.kind != "control"
                        for p in s.points if p.accuracy and p.picture)
        entries = tuple(Entry(s, p, bool(p.accuracy and p.picture and s.kind != "control"
                                         and (picture(p).median, p.accuracy.wrong) in best))
                        for s in subject.series for p in s.points)
        return SubjectView(subject, f"speed/{slug(subject.id)}.html", charts[0] if charts else None, charts, entries,
                           tuple(subject.findings), subject.findings[0] if subject.findings else "")

    def _rows(self, series: list[Series], cost: Callable, error: Callable) -> list[Row]:
        """The points that have both; faults and refusals go into the gutter, what does not apply is left out."""
        rows = []
        for s in series:
            values, failed = [], []
            for p in s.points:
                name = s.title + (f", {p.label}" if p.label else "")
                if p.state != "ok":
                    failed.append(f"{name}: {p.state}, {p.message}")
                    continue
                c = cost(p)
                spread = (c.median, c.low, c.high) if hasattr(c, "median") else (c, c, c)
                if not finite(spread[0], error(p)) or spread[0] <= 0:
                    continue
                scale = 1000 if hasattr(c, "median") else 1
                c, low, high = (scale * v for v in spread)
                values.append(Value(c, error(p), f"{name}: {c:.3g}{' ms' if scale > 1 else ''}, error {error(p):.3g}",
                                    max(low, c / 1e3), high))
            if values or failed:
                rows.append(Row(self.styles[s.id], tuple(values), tuple(failed)))
        return rows

    def _growth(self, growth: Growth, second: bool) -> Scatter:
        rows = []
        for number, line in enumerate(growth.lines):
            values, failed = [], []
            for p in line.points:
                if p.state != "ok":
                    failed.append(f"{line.label} at {p.x:g}: {p.state}, {p.message}")
                elif second and finite(p.second):
                    values.append(Value(p.x, p.second, f"{line.label}: {p.x:g}, {p.second:.3g}", p.x, p.x))
                elif not second and p.picture:
                    t = self._time_of_growth(growth, p.picture)
                    values.append(Value(p.x, t, f"{line.label}: {p.x:g}, {t:.3g} s", p.x, p.x))
            rows.append(Row(Style(line.label, number), tuple(values), tuple(failed)))
        clock = "wall time" if _of_threads(growth) else self.time
        return scatter(f"growth-{slug(growth.id)}-{int(second)}", growth.title, growth.x_label,
                       growth.second_label if second else f"{clock} of a picture, s", rows, judged=False,
                       share=second and _of_threads(growth))

    def _time_of_growth(self, growth: Growth, times: Times) -> float:
        """Threads can only be told apart by the clock on the wall."""
        return times.wall.median if _of_threads(growth) else getattr(times, self.clock).median

    def key(self, ids: set[str] | None = None) -> list[Style]:
        """The styles of the series called `ids`, or of all."""
        return [style for id, style in self.styles.items() if ids is None or id in ids]


def _of_threads(growth: Growth) -> bool:
    return growth.id == "threads"


def _styles(chart: Chart) -> dict[str, Style]:
    """A style for every series; sweeps of one method share colour and mark, all but the first are hollow."""
    numbers: dict[str, int] = {}
    controls = 0
    styles: dict[str, Style] = {}
    for s in (s for subject in chart.subjects for s in subject.series):
        if s.id not in styles:
            if s.kind == "control":
                styles[s.id] = Style(s.title, controls, muted=True)
                controls += 1
                continue
            hollow = s.method in numbers
            styles[s.id] = Style(s.title, numbers.setdefault(s.method, len(numbers)), hollow)
    return styles
