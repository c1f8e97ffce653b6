"""A study as a log-log chart: from points to the coordinates that a template draws."""

from __future__ import annotations

import math
from dataclasses import dataclass

from comparisons.results import Series

from .axis import MOST_TICKS, LogAxis, Tick, log_ticks, padded
from .names import slug

WIDTH, HEIGHT = 640, 400  # of the drawing, in its own units
LEFT, RIGHT, TOP, BOTTOM = 74, 18, 40, 58  # margins
BAND = 34  # height of the band below the axis where exact zeros are drawn

# one mark a line, besides its colour and its dashes: a path around (0, 0)
MARKS = ("M-4.5 0a4.5 4.5 0 1 0 9 0a4.5 4.5 0 1 0 -9 0Z", "M-4.2 -4.2H4.2V4.2H-4.2Z", "M0 -5.8L5.8 0L0 5.8L-5.8 0Z",
         "M0 -5.4L5.2 4H-5.2Z", "M0 5.4L5.2 -4H-5.2Z", "M-5 -1.7H-1.7V-5H1.7V-1.7H5V1.7H1.7V5H-1.7V1.7H-5Z",
         "M-5.2 -2.8L-2.8 -5.2L0 -2.4L2.8 -5.2L5.2 -2.8L2.4 0L5.2 2.8L2.8 5.2L0 2.4L-2.8 5.2L-5.2 2.8L-2.4 0Z",
         "M0 -6.2L1.5 -2.1L5.9 -1.9L2.5 0.8L3.6 5L0 2.6L-3.6 5L-2.5 0.8L-5.9 -1.9L-1.5 -2.1Z",
         "M-4.6 -5.2H4.6L1 0L4.6 5.2H-4.6L-1 0Z", "M5.2 0L2.6 4.5L-2.6 4.5L-5.2 0L-2.6 -4.5L2.6 -4.5Z")


@dataclass(frozen=True)
class Point:
    x: float
    y: float
    values: tuple[float, float]


@dataclass(frozen=True)
class Line:
    label: str
    style: int  # which of the MARKS
    mark: str
    slope: float | None
    points: tuple[Point, ...]  # all that can be drawn
    segments: tuple[str, ...]  # polylines through the positive ones


@dataclass(frozen=True)
class Chart:
    anchor: str
    series: Series
    lines: tuple[Line, ...]
    x_ticks: tuple[Tick, ...]
    y_ticks: tuple[Tick, ...]
    has_zeros: bool
    floor: float  # where the logarithmic axis ends
    left_out: int  # points that no logarithmic chart can show

    width, height, left, right, top, bottom, band = WIDTH, HEIGHT, LEFT, RIGHT, TOP, BOTTOM, BAND

    @property
    def title(self) -> str:
        return self.series.title

    @property
    def x_label(self) -> str:
        return self.series.x_label

    @property
    def y_label(self) -> str:
        return self.series.y_label


def chart(series: Series) -> Chart:
    """Places every point with x > 0: those with y > 0 on the axes, those with y = 0 in a band of their own."""
    points = [(x, y) for line in series.lines.values() for x, y in line]
    shown = [(x, y) for x, y in points if math.isfinite(x) and math.isfinite(y) and x > 0 and y >= 0]
    zeros = any(y == 0 for _, y in shown)
    floor = HEIGHT - BOTTOM - (BAND if zeros else 0)
    x_values = [x for x, _ in shown]
    horizontal = LogAxis(*padded(x_values, 0.06), LEFT, WIDTH - RIGHT)
    vertical = LogAxis(*padded([y for _, y in shown if y > 0], 0.08), floor, TOP)
    in_band = floor + BAND / 2
    lines = tuple(_line(i, label, values, series.slope.get(label), horizontal, vertical, in_band)
                  for i, (label, values) in enumerate(series.lines.items()))
    distinct = sorted(set(x_values))
    x_at = distinct if len(distinct) <= MOST_TICKS and horizontal.apart(distinct, 40) else log_ticks(*horizontal.range)
    return Chart(slug(series.id), series, lines, horizontal.ticks(x_at), vertical.ticks(log_ticks(*vertical.range)),
                 zeros, floor, len(points) - len(shown))


def _line(number: int, label: str, values, slope, horizontal: LogAxis, vertical: LogAxis, in_band: float) -> Line:
    points, segments, segment = [], [], []
    for x, y in sorted(values):
        if not (math.isfinite(x) and x > 0 and math.isfinite(y) and y >= 0):
            continue
        point = Point(horizontal.at(x), vertical.at(y) if y > 0 else in_band, (x, y))
        points.append(point)
        if y > 0:
            segment.append(point)
        else:  # a zero has no place on a logarithmic axis: the line breaks
            segments.append(segment)
            segment = []
    segments.append(segment)
    paths = tuple(" ".join(f"{p.x},{p.y}" for p in s) for s in segments if len(s) > 1)
    return Line(label, number % len(MARKS), MARKS[number % len(MARKS)], slope, tuple(points), paths)
