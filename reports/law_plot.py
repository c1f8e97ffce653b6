"""Laws of failure as charts: the measured rate over the rate that theory demands, with the band of the sample."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from comparisons.stability.document import WRONG
from comparisons.stability.document import FamilyRecord, LawRecord

from .axis import MOST_TICKS, LogAxis, LinearAxis, Tick, log_ticks, padded
from .chart import MARKS
from .names import slug
from .numbers import Number, parts
from .plot import BOTTOM, HEIGHT, LEFT, RIGHT, TOP, WIDTH, Bar, Curve, Mark, Marks, Plot, polyline

ZERO_SLOT = 46  # width kept for p = 0, which has no place on a logarithmic axis
TOPS = ((0.01, 0.002), (0.02, 0.005), (0.05, 0.01), (0.1, 0.02), (0.2, 0.05), (0.5, 0.1), (1.0, 0.25))  # and steps


@dataclass(frozen=True)
class Law:
    """One law, with all methods that it holds for."""

    sentence: str
    counts: str  # what the rate counts, in words
    methods: tuple[str, ...]
    holds: bool
    plot: Plot | None  # None: the rate is `always` the same, by theory and as measured; a sentence says that
    always: float | None


def laws(family: FamilyRecord) -> list[Law]:
    """The laws of a family, broken ones first; methods that obey the same one share a chart."""
    groups: dict[tuple, list[LawRecord]] = {}
    for law in family.laws:
        expected = tuple((p.value, p.expected, p.low, p.high) for p in law.points)
        groups.setdefault((law.sentence, tuple(law.kinds), tuple(law.curve), expected, law.holds), []).append(law)
    found = [_law(family, members, f"law-{slug(family.id)}-{k}") for k, members in enumerate(groups.values())]
    return sorted(found, key=lambda law: (law.holds, law.plot is None))


def _law(family: FamilyRecord, members: list[LawRecord], anchor: str) -> Law:
    first = members[0]
    rates = {rate for _, rate in first.curve} | {r for m in members for p in m.points for r in (p.expected, p.measured)}
    always = next(iter(rates)) if len(rates) == 1 and rates <= {0.0, 1.0} else None
    counts = "wrong answers" if set(first.kinds) == set(WRONG) else f"{' or '.join(first.kinds)} answers"
    plot = _plot(family, members, counts, anchor) if always is None else None
    return Law(first.sentence, counts, tuple(law.method for law in members), first.holds, plot, always)


def _plot(family: FamilyRecord, members: list[LawRecord], counts: str, anchor: str) -> Plot:
    first = members[0]
    place, x_ticks = _horizontal(family, [p.value for p in first.points] + [x for x, _ in first.curve])
    rates = [rate for _, rate in first.curve] + [r for m in members for p in m.points for r in (p.measured, p.high)]
    top, step = next((t for t in TOPS if t[0] >= max(rates, default=1)), TOPS[-1])
    vertical = LinearAxis(top, HEIGHT - BOTTOM, TOP)
    curve = Curve("by theory", 5, polyline([(place(x), vertical.at(y)) for x, y in first.curve]))
    bars = tuple(Bar(place(p.value), vertical.at(p.low), vertical.at(p.high)) for p in first.points)
    same: dict[tuple, list[str]] = {}  # methods that measured the same share their marks
    for law in members:
        same.setdefault(tuple(p.measured for p in law.points), []).append(law.method)
    marks = tuple(
        Marks(", ".join(names), style % 5, MARKS[style % 5],
              tuple(Mark(place(p.value), vertical.at(rate), f"{', '.join(names)} at {p.value:g}: {rate:.3g}, by theory "
                         f"{p.expected:.3g}", not p.low <= rate <= p.high) for p, rate in zip(first.points, measured)))
        for style, (measured, names) in enumerate(same.items()))
    digits = 0 if step >= 0.01 else 1
    return Plot(anchor, f"{family.title}: {first.sentence}", family.parameter, f"share of rays: {counts}", x_ticks,
                vertical.ticks(step, lambda value: Number(f"{100 * value:.{digits}f} %")), (curve,), bars, marks)


def _horizontal(family: FamilyRecord, values: list[float]) -> tuple[Callable[[float], float], tuple[Tick, ...]]:
    """Where a value stands, easy on the left and hard on the right as in the map; and the ticks."""
    positive = sorted({v for v in values if v > 0})
    has_zero = len(positive) < len(set(values))
    falls = family.values[0] > family.values[-1]
    left, right = LEFT + 12, WIDTH - RIGHT
    if has_zero:
        left, right = (left, right - ZERO_SLOT) if falls else (left + ZERO_SLOT, right)
    zero = WIDTH - RIGHT - ZERO_SLOT / 3 if falls else LEFT + 12 + ZERO_SLOT / 3
    axis = LogAxis(*padded(positive, 0.04), *((right, left) if falls else (left, right)))
    distinct = sorted({v for v in family.values if axis.low <= v <= axis.high})
    few = len(distinct) <= MOST_TICKS and axis.apart(distinct, 44)
    ticks = axis.ticks(distinct if few else log_ticks(*axis.range))
    return (lambda value: axis.at(value) if value > 0 else zero), ticks + ((Tick(zero, parts(0)),) if has_zero else ())
