"""Points of cost and error on logarithmic axes: the frontier, a band for what is no error, a gutter for what failed."""

from __future__ import annotations

import math
from dataclasses import dataclass

from comparisons.charting.document import frontier

from .axis import MOST_TICKS, LinearAxis, LogAxis, Tick, log_ticks, padded
from .chart import MARKS
from .plot import polyline

WIDTH, HEIGHT = 640, 430  # of the drawing, in its own units
LEFT, RIGHT, TOP, BOTTOM = 74, 18, 40, 58  # margins
BAND = 62  # height of the band of errors that are none; marks stand in it in rows, so that they do not hide each other
ROWS = 5
GUTTER = 46  # width of the strip of points without a result
CONTROLS = ("M-4.5 -4.5L4.5 4.5M-4.5 4.5L4.5 -4.5", "M-4.5 0a4.5 4.5 0 1 0 9 0a4.5 4.5 0 1 0 -9 0Z")


@dataclass(frozen=True)
class Style:
    """How the points of one series are drawn."""

    label: str
    number: int  # which colour, and which of the MARKS
    hollow: bool = False
    muted: bool = False  # a control, there for orientation

    @property
    def mark(self) -> str:
        marks = CONTROLS if self.muted else MARKS
        return marks[self.number % len(marks)]

    @property
    def classes(self) -> str:
        return "muted" if self.muted else f"line-{self.number % len(MARKS)}"


@dataclass(frozen=True)
class Value:
    """A point before it has a place. `low` and `high` are the spread of the cost."""

    cost: float
    error: float
    text: str
    low: float
    high: float


@dataclass(frozen=True)
class Row:
    """One series: its points, and the texts of those that failed."""

    style: Style
    values: tuple[Value, ...]
    failed: tuple[str, ...] = ()


@dataclass(frozen=True)
class Placed:
    x: float
    y: float
    text: str
    low: float
    high: float
    best: bool = False


@dataclass(frozen=True)
class PlacedRow:
    style: Style
    points: tuple[Placed, ...]
    failed: tuple[Placed, ...]
    line: str  # of a polyline


@dataclass(frozen=True)
class Scatter:
    anchor: str
    title: str
    x_label: str
    y_label: str
    x_ticks: tuple[Tick, ...]
    y_ticks: tuple[Tick, ...]
    rows: tuple[PlacedRow, ...]
    frontier: str  # of a polyline
    floor: float
    zero_label: str
    has_zeros: bool
    right: float
    has_gutter: bool
    width, height, left, top, bottom, band, gutter = WIDTH, HEIGHT, LEFT, TOP, BOTTOM, BAND, GUTTER


def scatter(anchor: str, title: str, x_label: str, y_label: str, rows: list[Row], *, nothing: float = 0.0,
            zero_label: str = "exactly 0", judged: bool = True, share: bool = False) -> Scatter:
    """Places all `rows`. Errors up to `nothing` stand in the band; `judged` points have a frontier.

    With `share` the vertical axis is linear and begins at 0.
    """
    values = [v for row in rows for v in row.values]
    zeros = not share and any(v.error <= nothing for v in values)
    failures = any(row.failed for row in rows)
    right = RIGHT + (GUTTER if failures else 0)
    floor = HEIGHT - BOTTOM - (BAND if zeros else 0)
    horizontal = LogAxis(*padded([v.cost for v in values], 0.06), LEFT, WIDTH - right)
    if share:
        vertical = LinearAxis(1.0 if all(v.error <= 1 for v in values) else 1.25, floor, TOP)
        y_ticks = vertical.ticks(0.25)
    else:
        vertical = LogAxis(*padded([v.error for v in values if v.error > nothing], 0.08), floor, TOP)
        y_ticks = vertical.ticks(log_ticks(*vertical.range))
    best = frontier((v.cost, max(v.error, nothing)) for row in rows if not row.style.muted for v in row.values) \
        if judged else []
    placed, slot = [], 0
    for k, row in enumerate(rows):
        in_band = floor + BAND * (k % ROWS + 0.7) / (ROWS + 0.4)
        place = lambda v: vertical.at(v.error) if share or v.error > nothing else round(in_band, 2)
        points = tuple(Placed(horizontal.at(v.cost), place(v), v.text, horizontal.at(v.low), horizontal.at(v.high),
                              not row.style.muted and (v.cost, max(v.error, nothing)) in best) for v in row.values)
        failed = []
        for text in row.failed:  # from the top downwards, two abreast
            x = WIDTH - right + GUTTER * (0.3 if slot % 2 == 0 else 0.72)
            failed.append(Placed(round(x, 2), TOP + 12 + 17 * (slot // 2), text, x, x))
            slot += 1
        placed.append(PlacedRow(row.style, points, tuple(failed),
                                polyline([(p.x, p.y) for p in points]) if len(points) > 1 else ""))
    distinct = sorted({v.cost for v in values})
    few = not judged and len(distinct) <= MOST_TICKS and horizontal.apart(distinct, 44)  # a parameter that was swept
    x_ticks = horizontal.ticks(distinct if few else log_ticks(*horizontal.range))
    return Scatter(anchor, title, x_label, y_label, x_ticks, y_ticks, tuple(placed),
                   _steps({(p.x, p.y) for row in placed for p in row.points if p.best}, horizontal.end),
                   floor, zero_label, zeros, right, failures)


def _steps(best: set[tuple[float, float]], end: float) -> str:
    """Along the frontier from point to point: what lies above and to the right of it is beaten."""
    points: list[tuple[float, float]] = []
    for x, y in sorted(best):
        if points:
            points.append((x, points[-1][1]))
        points.append((x, y))
    return polyline([*points, (end, points[-1][1])]) if points else ""


def finite(*numbers: float | None) -> bool:
    return all(n is not None and math.isfinite(n) for n in numbers)
