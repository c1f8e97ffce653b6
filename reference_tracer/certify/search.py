"""Crossings of any f by ball arithmetic: the leftmost part of the ray first, nothing left before it is decided."""

from __future__ import annotations

from contextlib import contextmanager

from flint import arb, ctx, fmpq

from ..numbers.exact import ORDER, Series, rational
from ..surfaces.surface import Surface

MOST_SEGMENTS = 20_000
NARROWEST = fmpq(1, 2**80)  # of the ray's range; what is not decided on such a segment stays undecided
MOST_BITS = 3072  # to tell the sign of f at a point
NEVER_BACK = "starts on the wrong side of the surface and does not come back"
SPLITS = tuple(fmpq(k, 32) for k in (16, 15, 17, 13, 19))  # of a segment; the next where f may be zero at one
UNIT = arb(0, 1)  # the ball [-1, 1]


class Undecidable(ArithmeticError):
    """Ball arithmetic cannot tell; the text says why."""


@contextmanager
def precision(bits: int):
    """flint's working precision and the length of its series, restored afterwards."""
    cap, ctx.cap = ctx.cap, ORDER
    try:
        with ctx.workprec(bits):
            yield
    finally:
        ctx.cap = cap


def search(surface: Surface, o, d, inside: bool, limit, bits: int = 96, only_first: bool = False):
    """The crossings of the ray on (0, limit), ascending, as line.py defines them, and whether it starts on the wrong
    side: (list of arb, bool). Raises Undecidable.

    Segments are halved until g provably has no zero there or is monotone; the signs of g at their ends, certain at
    whatever precision that takes, then tell whether it crosses.
    """
    with precision(bits + 32):
        return _search(_Ray(surface, o, d), -1 if inside else 1, rational(limit), bits, only_first)


def _search(ray: _Ray, side: int, limit: fmpq, bits: int, only_first: bool):
    crossings, skip = [], False
    start, end = ray.sign(fmpq(0)), ray.sign(limit)
    if end == 0:
        finite = ray.series(arb(limit))[0].is_finite()
        raise Undecidable("the surface passes where the ray ends" if finite else "f is not finite along the ray")
    wrong_start = start == -side
    if wrong_start:
        slope = ray.series(arb(0))[1] * side
        if not _excludes_zero(slope):
            raise Undecidable("starts along the surface, on its wrong side")
        skip = bool(slope > 0)
        crossings = [] if skip else [arb(0)]
        side = start
    stack, segments = [(fmpq(0), limit, end)], 0
    while stack and not (only_first and crossings):
        low, high, sign_high = stack.pop()
        segments += 1
        if not ray.is_monotone(low, high):
            if high - low <= NARROWEST * limit or segments > MOST_SEGMENTS:
                raise Undecidable(ray.why_not(low, high))
            split, sign = ray.split(low, high)
            stack += [(split, high, sign_high), (low, split, sign)]
        elif sign_high != side:
            if skip:
                skip = False
            elif low == 0 and start == 0:  # g is zero at 0 and monotone: the ray leaves its side as it starts
                crossings.append(arb(0))
                wrong_start = True
            else:
                crossings.append(ray.zero(low, high, sign_high, bits))
            side = sign_high
    if skip:
        raise Undecidable(NEVER_BACK)
    return crossings, wrong_start


class _Ray:
    """g(t) = f(o + t d) with its first two derivatives over balls of t; f is the regular form: a multiple root would
    leave its sign open on both sides."""

    def __init__(self, surface: Surface, o, d):
        self.surface = surface
        self.o, self.d = [rational(v) for v in o], [rational(v) for v in d]
        self.orientation = -1 if surface.inside == "positive" else 1

    def series(self, t: arb) -> tuple[arb, arb, arb]:
        """Balls for g, g' and g''/2 on the ball t."""
        f = self.surface
        parameters = {name: Series.constant(value) for name, value in f.parameters.items()}
        s = f.regular_form(*Series.along(map(arb, self.o), map(arb, self.d), t), **parameters).s
        return tuple(self.orientation * s[k] for k in range(ORDER))

    def sign(self, t: fmpq) -> int:
        """The sign of g at t, from as many bits as it takes; 0 where MOST_BITS do not tell: it may be zero."""
        bits = ctx.prec
        while bits <= MOST_BITS:
            with ctx.workprec(bits):
                value = self.series(arb(t))[0]
                if _excludes_zero(value):
                    return 1 if value > 0 else -1
            bits *= 2
        return 0

    def is_monotone(self, low: fmpq, high: fmpq) -> bool:
        """Whether g provably has no zero in [low, high] or g' has none.

        Each is enclosed directly and by its Taylor polynomial about the middle, whose excess falls with the square of
        the width.
        """
        middle, offset = arb((low + high) / 2), UNIT * arb((high - low) / 2)
        g, slope, curvature = self.series(middle + offset)
        if _excludes_zero(g) or _excludes_zero(slope):
            return True
        g0, slope0, _ = self.series(middle)
        return (_excludes_zero(g0 + slope * offset) or _excludes_zero(slope0 + 2 * curvature * offset)
                or _excludes_zero(g0 + slope0 * offset + curvature * (offset * offset)))

    def split(self, low: fmpq, high: fmpq) -> tuple[fmpq, int]:
        """A point near the middle where the sign of g is certain, and that sign."""
        for share in SPLITS:
            point = low + (high - low) * share
            if sign := self.sign(point):
                return point, sign
        raise Undecidable(self.why_not(low, high))

    def why_not(self, low: fmpq, high: fmpq) -> str:
        value = self.series(arb(low).union(arb(high)))[0]
        return "near a touching point" if value.is_finite() else "f is not finite along the ray"

    def zero(self, low: fmpq, high: fmpq, sign_high: int, bits: int) -> arb:
        """The only zero in [low, high], where g is monotone and changes sign, to about `bits` bits."""
        goal = max(fmpq(1), high) / (1 << bits)
        while high - low > goal:
            x = (low + high) / 2
            slope = self.series(arb(low).union(arb(high)))[1]
            newton = arb(x) - self.series(arb(x))[0] / slope  # interval Newton: the zero lies in it
            if newton.is_finite() and newton.rad() < arb((high - low) / 5):
                low, high = max(low, rational(newton.lower())), min(high, rational(newton.upper()))
                continue
            sign = self.sign(x)
            if sign == 0:
                return arb(x)
            low, high = (low, x) if sign == sign_high else (x, high)
        return arb(low).union(arb(high))


def _excludes_zero(ball: arb) -> bool:
    return ball.is_finite() and not ball.contains(0)
