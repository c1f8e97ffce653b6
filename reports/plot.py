"""A chart with a linear vertical axis, in coordinates that a template draws: curves, bars of uncertainty, marks."""

from __future__ import annotations

from dataclasses import dataclass

from .axis import Tick

WIDTH, HEIGHT = 560, 330  # of the drawing, in its own units
LEFT, RIGHT, TOP, BOTTOM = 62, 18, 40, 56  # margins


@dataclass(frozen=True)
class Curve:
    """A line without marks; `style` is its colour and its dashes."""

    label: str
    style: int
    points: str  # of a polyline


@dataclass(frozen=True)
class Bar:
    """From `low` to `high` at x."""

    x: float
    low: float
    high: float


@dataclass(frozen=True)
class Mark:
    x: float
    y: float
    text: str
    is_off: bool = False  # where it must not be


@dataclass(frozen=True)
class Marks:
    label: str
    style: int
    shape: str  # one of chart.MARKS
    points: tuple[Mark, ...]


@dataclass(frozen=True)
class Plot:
    anchor: str
    title: str
    x_label: str
    y_label: str
    x_ticks: tuple[Tick, ...]
    y_ticks: tuple[Tick, ...]
    curves: tuple[Curve, ...] = ()
    bars: tuple[Bar, ...] = ()
    marks: tuple[Marks, ...] = ()

    has_zeros = False
    width, height, left, right, top, bottom = WIDTH, HEIGHT, LEFT, RIGHT, TOP, BOTTOM


def polyline(points: list[tuple[float, float]]) -> str:
    return " ".join(f"{x},{y}" for x, y in points)
