"""Crossings of any f by ball arithmetic: the leftmost part of the ray first, nothing left before it is decided."""

from __future__ import annotations

from contextlib import contextmanager

from flint import arb, ctx, fmpq

from ..numbers.exact import ORDER, Series, rational
from ..surfaces.surface import Surface

MOST_SEGMENTS = 20_000
NARROWEST = fmpq(1, 2**80)  # of the ray's range; what is not decided on such a segment stays undecided
MOST_BITS = 3072  # to tell the sign of f at a point
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


class _Ray:
    """g(t) = f(o + t d) with its first two derivatives over balls of t."""

    def __init__(self, surface: Surface, o, d):
        self.surface = surface
        self.o, self.d = [rational(v) for v in o], [rational(v) for v in d]

    def series(self, t: arb) -> tuple[arb, arb, arb]:
        """Balls for g, g' and g''/2 on the ball t."""
        f = self.surface
        parameters = {name: Series.constant(value) for name, value in f.parameters.items()}
        s = f.function(*Series.along(map(arb, self.o), map(arb, self.d), t), **parameters).s
        sign = -1 if f.inside == "positive" else 1
        return sign * s[0], sign * s[1], sign * s[2]

    def sign(self, t: fmpq) -> int:
        """The sign of g at t, from as many bits as it takes; 0 where MOST_BITS do not tell: it may be zero."""
        bits = ctx.prec
        while bits <= MOST_BITS:
            with ctx.workprec(bits):
                value = self.series(arb(t))[0]
                if value.is_finite() and not value.contains(0):
                    return 1 if value > 0 else -1
            bits *= 2
        return 0

    def certain(self, low: fmpq, high: fmpq) -> tuple[bool, bool]:
        """Whether g has no zero in [low, high], and whether it has at most one there, being monotone.

        Each of g and g' is enclosed directly and by its Taylor polynomial about the middle, whose excess falls with
        the square of the width.
        """
        h = arb((high - low) / 2)
        middle, offset = arb((low + high) / 2), UNIT * h
        g, slope, curvature = self.series(middle + offset)
        if _excludes_zero(g):
            return True, True
        g0, slope0, _ = self.series(middle)
        if _excludes_zero(g0 + slope * offset) or _excludes_zero(g0 + slope0 * offset + curvature * (offset * offset)):
            return True, True
        return False, _excludes_zero(slope) or _excludes_zero(slope0 + 2 * curvature * offset)

    def refined(self, low: fmpq, high: fmpq, sign_high: int, bits: int) -> arb:
        """The only zero in [low, high], where g is monotone and changes sign, to about `bits` bits."""
        goal = fmpq(1, fmpz_power(bits)) * max(1, high)
        while high - low > goal:
            x = (low + high) / 2
            value, slope, _ = self.series(arb(low).union(arb(high)))
            at_x = self.series(arb(x))[0]
            newton = arb(x) - at_x / slope if _excludes_zero(slope) else arb.nan()
            probes = [x]
            if newton.is_finite():  # interval Newton: the zero lies in `newton`, and within the bracket
                a, b = rational(newton.lower()), rational(newton.upper())
                if b - a < (high - low) / 2:
                    low, high = max(low, a), min(high, b)
                    continue
            for probe in probes:
                sign = self.sign(probe)
                if sign == 0:
                    return arb(probe)
                low, high = (low, probe) if sign == sign_high else (probe, high)
        return arb(low).union(arb(high))


def fmpz_power(bits: int) -> int:
    return 1 << bits


def _excludes_zero(ball: arb) -> bool:
    return ball.is_finite() and not ball.contains(0)


def search(surface: Surface, o, d, inside: bool, limit, bits: int = 96, only_first: bool = False) -> list[arb]:
    """The crossings of the ray on (0, limit), ascending, in the sense of line.py. Raises Undecidable."""
    with precision(bits + 32):
        return _search(_Ray(surface, o, d), inside, rational(limit), bits, only_first)
