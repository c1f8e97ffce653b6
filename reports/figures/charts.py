"""Charts, drawn by matplotlib as SVG to stand in a page: its colours are the page's own, in light and in dark.

Series are named at their lines. Zeros have no place on a logarithmic axis: they stand in a shaded band beyond its end.
"""

from __future__ import annotations

import io
import itertools
import math
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from markupsafe import Markup, escape

from ..text.numbers import is_plain, parts, power

WIDTH, HEIGHT, FONT = 640, 400, 12.5  # CSS pixels of the drawing, before a page scales it
LEFT, RIGHT, TOP, BOTTOM = 70, 112, 34, 56  # margins; names of series run into the right one
MOST_TICKS = 7
BAND = 0.16  # of an axis's length: where zeros stand
ROWS = 5  # in which the series of a band take turns, so that they do not hide each other
MARKS = "osD^vPX*hp"
PAGE = ("ink", "soft", "line", "paper", "faint", "differs", "absent", *(f"line-{k}" for k in range(len(MARKS))))  # CSS


def _colour(name: str) -> str:
    """A colour that stands for the page's colour `name` until the drawing is complete."""
    return f"#00fe{PAGE.index(name):02x}"


SETTINGS = {"svg.fonttype": "none", "font.size": FONT, "text.parse_math": False, "axes.spines.top": False,
            "axes.spines.right": False, "xtick.minor.size": 0, "ytick.minor.size": 0, "xtick.major.size": 0,
            "ytick.major.size": 0, "axes.grid": True, "axes.axisbelow": True, "axes.facecolor": "none",
            "lines.markersize": 7.5,
            **{f"{axis}tick.color": _colour("soft") for axis in "xy"}, "grid.color": _colour("line"),
            "axes.edgecolor": _colour("soft"), "axes.labelcolor": _colour("ink"), "text.color": _colour("ink")}


@dataclass(frozen=True)
class Axis:
    """From values to places: logarithmic with a band for values up to `nothing` if there are any, or linear from 0.

    `values` are all that must have a place; `step` makes the axis linear.
    """

    label: str
    values: Sequence[float]
    nothing: float = 0.0
    zero: str = "exactly 0"  # what the band stands for
    few: bool = False  # whether the values themselves are the ticks where they are few
    falls: bool = False  # whether it runs from high to low
    step: float | None = None
    write: Callable[[float], str] | None = None

    @property
    def positive(self) -> list[float]:
        return [v for v in self.values if v > self.nothing]

    @property
    def has_band(self) -> bool:
        return self.step is None and len(self.positive) < len(self.values)

    @property
    def range(self) -> tuple[float, float]:
        """Of the values that have a place; a logarithmic one spans a factor of 4 at least."""
        if self.step is not None:
            return 0.0, math.ceil(max(self.values, default=1) / self.step - 1e-9) * self.step or self.step
        low, high = (math.log10(pick(self.positive, default=1.0)) for pick in (min, max))
        pad = max(0.06 * (high - low), (math.log10(4) - (high - low)) / 2)
        return 10 ** (low - pad), 10 ** (high + pad)

    @property
    def floor(self) -> float:
        """Where the axis ends, its band included."""
        low, high = self.range
        return low * (low / high) ** (BAND / (1 - BAND)) if self.has_band else low

    def place(self, value: float, row: float = 0.5) -> float:
        """The value itself, or one in the band; `row` is the share of the band below it."""
        if not self.has_band or value > self.nothing:
            return value
        return self.floor * (self.range[0] / self.floor) ** row

    @property
    def ticks(self) -> dict[float, str]:
        """Places and what is written there."""
        low, high = self.range
        if self.step is not None:
            return {v: (self.write or str)(v) for v in np.arange(0, high + self.step / 2, self.step).tolist()}
        distinct = sorted(set(self.positive))
        apart = all(math.log(b / a) > 0.08 * math.log(high / low) for a, b in itertools.pairwise(distinct))
        found = distinct if self.few and apart and 1 < len(distinct) <= MOST_TICKS else log_ticks(low, high)
        write = self.write or (parts if all(map(is_plain, found)) else power)  # one notation an axis
        return {**({self.place(0): self.zero} if self.has_band else {}), **{v: str(write(v)) for v in found}}


@dataclass(frozen=True)
class Line:
    """One series."""

    label: str
    points: Sequence[tuple[float, float]]
    number: int = 0  # of its colour and its mark
    style: str = "marks"  # joined by a line; or "hollow", "muted", "apart" without a line; without marks "plain", "bands"
    spread: Sequence[tuple[float, float]] = ()  # low and high of every point: of y in "bands", else of x
    off: Sequence[bool] = ()  # which points lie where they must not

    @property
    def colour(self) -> str:
        return _colour("absent" if self.style == "muted" else f"line-{self.number % len(MARKS)}")


def chart(anchor: str, title: str, x: Axis, y: Axis, lines: Sequence[Line],
          frontier: Sequence[tuple[float, float]] = ()) -> Markup:
    """The lines on their axes as an <svg>. Line k is the group with the id `anchor`-k; `frontier` are points to ring."""
    import matplotlib
    from matplotlib.backends.backend_svg import FigureCanvasSVG
    from matplotlib.figure import Figure

    with matplotlib.rc_context({**SETTINGS, "svg.hashsalt": anchor}):
        figure = Figure(figsize=(WIDTH / 72, HEIGHT / 72), dpi=72)
        figure.patch.set_visible(False)
        FigureCanvasSVG(figure)
        axes = figure.add_axes((LEFT / WIDTH, BOTTOM / HEIGHT, 1 - (LEFT + RIGHT) / WIDTH, 1 - (TOP + BOTTOM) / HEIGHT))
        _frame(axes, x, y)
        anchors, taken = [], []
        for k, line in enumerate(lines):
            row = (k % ROWS + 0.7) / (ROWS + 0.4)
            points = [(x.place(a), y.place(b, row)) for a, b in line.points]
            if points:
                _draw(axes, f"{anchor}-{k}", line, points)
                pixels = axes.transData.transform(points)
                anchors.append((line, pixels))
                taken.append(_boxes(_along(pixels) if line.style not in ("apart", "bands") else pixels))
        _frontier(axes, [(x.place(a), y.place(b)) for a, b in frontier], x.range[1])
        _name(figure, anchors, np.concatenate(taken) if taken else np.empty((0, 4)))
        text = io.StringIO()
        figure.savefig(text, format="svg")
    return _for_a_page(text.getvalue(), anchor, title)


def log_ticks(low: float, high: float) -> list[float]:
    """Round values between `low` and `high`, as many as a chart has room for: 1-2-5, decades, or every n-th decade."""
    first, last = math.floor(math.log10(low)), math.ceil(math.log10(high))
    for digits, stride in [((1, 2, 5), 1), ((1, 3), 1)] + [((1,), stride) for stride in range(1, last - first + 2)]:
        found = [float(f"{digit}e{exponent}") for exponent in range(first, last + 1) if exponent % stride == 0
                 for digit in digits]
        found = [value for value in found if low <= value <= high]
        if len(found) <= MOST_TICKS:
            return found
    return []


def _frame(axes, x: Axis, y: Axis) -> None:
    from matplotlib.ticker import NullLocator

    for axis, set_scale, set_limits, ticks, band in ((x, axes.set_xscale, axes.set_xlim, axes.xaxis, axes.axvspan),
                                                     (y, axes.set_yscale, axes.set_ylim, axes.yaxis, axes.axhspan)):
        set_scale("log" if axis.step is None else "linear")
        low, high = axis.floor, axis.range[1]
        set_limits(*((high, low) if axis.falls else (low, high)))
        ticks.set_minor_locator(NullLocator())
        ticks.set_ticks(list(axis.ticks), list(axis.ticks.values()))
        if axis.has_band:
            band(low, axis.range[0], facecolor=_colour("faint"), edgecolor="none")
    axes.set_xlabel(x.label, labelpad=7)
    axes.figure.text(6 / WIDTH, 1 - 14 / HEIGHT, y.label)


def _draw(axes, gid: str, line: Line, points: list[tuple[float, float]]) -> None:
    colour, paper = line.colour, _colour("paper")
    if line.style == "bands":
        for (a, _), (low, high) in zip(points, line.spread):
            axes.plot((a, a), (low, high), color=_colour("soft"), lw=1.4, marker="_", ms=9, clip_on=False)
        return
    drawn, = axes.plot(*zip(*points), color=colour, clip_on=False, zorder=3, gid=gid, **{
        "marks": {"lw": 1.6, "mec": paper, "mew": 0.8}, "apart": {"ls": "none", "mec": paper, "mew": 0.8},
        "hollow": {"lw": 1.6, "mfc": paper, "mew": 1.5}, "muted": {"lw": 1.2, "mfc": "none", "mew": 1.5},
        "plain": {"lw": 2}}[line.style])
    if line.style != "plain":
        drawn.set_marker(MARKS[line.number % len(MARKS)])
    for (_, b), ends in zip(points, line.spread):
        axes.plot(ends, (b, b), color=colour, lw=1, alpha=0.55)
    off = [point for point, wrong in zip(points, line.off) if wrong]
    if off:
        axes.plot(*zip(*off), ls="none", marker="x", ms=15, mew=2, color=_colour("differs"), clip_on=False, zorder=4)


def _frontier(axes, points: list[tuple[float, float]], end: float) -> None:
    """Rings, and steps from one to the next: what lies above and to the right of them is beaten."""
    if points:
        a, b = zip(*sorted(points))
        axes.step((*a, end), (*b, b[-1]), where="post", color=_colour("ink"), lw=6, alpha=0.12)
        axes.plot(a, b, ls="none", marker="o", ms=14, mfc="none", mec=_colour("ink"), mew=1.1, clip_on=False)


def _along(pixels: np.ndarray) -> np.ndarray:
    """The points of a line, and eight more on every piece of it."""
    pieces = [np.linspace(a, b, 9) for a, b in itertools.pairwise(pixels)]
    return np.concatenate([pixels, *pieces])


def _boxes(points: np.ndarray, width: float = 9, height: float = 9) -> np.ndarray:
    """(n, 4): left, lower, right and upper ends of boxes about points."""
    half = np.array([width, height]) / 2
    return np.hstack([points - half, points + half])


def _name(figure, anchors: list[tuple[Line, np.ndarray]], taken: np.ndarray) -> None:
    """Writes every line's name where it hides least, near a point of it: the last one where there is room."""
    turn = np.deg2rad(np.arange(0, 360, 30))
    for line, pixels in anchors:
        if not line.label:
            continue
        width, height = 0.54 * FONT * len(line.label), FONT + 2
        nearest = np.arange(len(pixels))[::-1][:4]
        choices, cost = [], []
        for rank, index in enumerate(nearest):
            for radius in (10, 22, 40, 65, 95):
                reach = radius + np.array([width, height]) / 2
                centre = pixels[index] + reach * np.stack([np.cos(turn), np.sin(turn)], 1)
                choices.append(np.hstack([centre, np.tile(pixels[index], (len(turn), 1))]))
                cost.append(np.full(len(turn), 4.0 * radius + 25 * rank) + 2 * np.arange(len(turn)))
        choices, cost = np.concatenate(choices), np.concatenate(cost)
        box = _boxes(choices[:, :2], width, height)
        low, high = np.maximum(box[:, None, :2], taken[None, :, :2]), np.minimum(box[:, None, 2:], taken[None, :, 2:])
        outside = (box[:, :2] < (LEFT - 4, BOTTOM)).any(1) | (box[:, 2:] > (WIDTH - 2, HEIGHT - TOP + 12)).any(1)
        best = np.argmin(cost + 3 * (high - low).clip(0).prod(2).sum(1) + 1e6 * outside)
        x, y, from_x, from_y = choices[best]
        if math.hypot(max(abs(x - from_x) - width / 2, 0), max(abs(y - from_y) - height / 2, 0)) > 24:
            end = np.clip((from_x, from_y), box[best, :2], box[best, 2:])
            figure.add_artist(_leader((from_x, from_y), end, line.colour))
        figure.text(x / WIDTH, y / HEIGHT, line.label, ha="center", va="center", color=line.colour, zorder=5)
        taken = np.concatenate([taken, box[best:best + 1]])


def _leader(start, end, colour: str):
    from matplotlib.lines import Line2D

    size = np.array([WIDTH, HEIGHT])
    return Line2D(*zip(np.array(start) / size, np.array(end) / size), color=colour, lw=0.8, alpha=0.6)


def _for_a_page(svg: str, anchor: str, title: str) -> Markup:
    """Without what only a file of its own needs. Tags alone are changed: texts are a document's own."""
    svg = svg[svg.index(">", svg.index("<svg")) + 1:].replace("xlink:href=", "href=")
    svg = re.sub(r"<metadata>.*?</metadata>|<style.*?</style>|<clipPath.*?</clipPath>|<!--.*?-->", "", svg, flags=re.S)
    svg = re.sub(r"\s*\n\s*", "\n", re.sub(r"<defs>\s*</defs>|<g/>", "", svg))
    used = set(re.findall(r'href="#(\w+)"', svg))

    def tag(found: re.Match) -> str:
        text = re.sub(r' clip-path="[^"]*"|; font-family: [^;"]*', "", found[0])  # all lies inside, in the page's type
        # an id that nothing refers to would stand in a page of several charts twice
        text = re.sub(r' id="([^"]*)"', lambda m: m[0] if m[1] in used or m[1].startswith(f"{anchor}-") else "", text)
        text = re.sub(r"#00fe([0-9a-f]{2})", lambda m: f"var(--{PAGE[int(m[1], 16)]})", text)
        return re.sub(r"(\.\d\d)\d+", r"\1", re.sub(r"font: ([\d.]+)px [^;\"]*", r"font-size: \1px", text))

    return Markup(f'<svg class="chart" viewBox="0 0 {WIDTH} {HEIGHT}" role="img" aria-label="{escape(title)}">'
                  + re.sub(r"<[^>]*>", tag, svg))
