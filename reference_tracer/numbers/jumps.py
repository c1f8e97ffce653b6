"""What is known of a function on both sides of a jump, where an interval of its argument holds one.

floor of [0.9, 1.1] is 0 or 1, of which [0, 1] is a poor enclosure: mod(x, 1) - 0.5 is -0.5 or 0.5 there and never zero.
`both_sides` evaluates once for each choice of sides, and returns the hull of what comes out: points on either side of the
jump belong to one of the choices. Slopes across a jump do not exist, whatever the choices give.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable
from contextvars import ContextVar
from dataclasses import dataclass, replace

from . import functions as fn

MOST_JUMPS = 3  # in one formula; each doubles what there is to evaluate


@dataclass
class _Choices:
    sides: tuple[bool, ...] | None  # of every jump, in the order of evaluation; None where they are only counted
    jumps: int = 0


_choices: ContextVar[_Choices | None] = ContextVar("choices", default=None)


def side(low, high, select=fn.select):
    """The enclosure [low, high] of a function that takes whole numbers, or its lower or upper end, as is being asked for;
    with more than one jump in between all of it."""
    choices = _choices.get()
    if choices is None:
        return low, high
    number, choices.jumps = choices.jumps, choices.jumps + 1
    if choices.sides is None:
        return low, high
    other = select(high - low <= 1, low, high) if not choices.sides[number] else select(high - low <= 1, high, low)
    return (other, high) if choices.sides[number] else (low, other)


def both_sides(evaluate: Callable[[], object]):
    """evaluate(), its value as narrow as the sides of all jumps allow."""
    whole, jumps = _with(None, evaluate)
    if not 1 <= jumps <= MOST_JUMPS:
        return whole
    parts = [_with(sides, evaluate)[0] for sides in itertools.product((False, True), repeat=jumps)]
    if not hasattr(whole, "derivatives"):
        return _hull(parts)
    return replace(whole, value=_hull([part.value for part in parts]))


def _with(sides: tuple[bool, ...] | None, evaluate: Callable[[], object]):
    choices = _Choices(sides)
    token = _choices.set(choices)
    try:
        return evaluate(), choices.jumps
    finally:
        _choices.reset(token)


def _hull(values: list):
    first, *others = values
    for other in others:
        first = first.hull(other)
    return first
