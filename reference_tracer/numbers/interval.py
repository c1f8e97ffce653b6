"""Interval arithmetic: f of an interval encloses every value f takes on it (Moore, Interval Analysis, 1966).

`Interval` rounds to nearest: an enclosure up to rounding, which is enough to miss no root in practice and costs least.
`OutwardInterval` widens every result by one unit in the last place: an enclosure that holds as a proof.
Bounds may be floats, NumPy or Dr.Jit arrays. Where an operation is undefined somewhere in the interval (a pole, a
square root below zero) the result is the whole line, from which nothing is ever concluded.
"""

from __future__ import annotations

import math

import drjit as dr
import numpy as np

from . import functions as fn

_PI = math.pi
_ULP = 2.0**-52  # one unit in the last place of 1.0, fp64
_TINY = 2.0**-1021  # below the smallest normal number: covers results that underflow


def _low(*values):
    m = values[0]
    for v in values[1:]:
        m = fn.minimum(m, v)
    return m


def _high(*values):
    m = values[0]
    for v in values[1:]:
        m = fn.maximum(m, v)
    return m


def _quotient(a, b):
    """a / b as IEEE arithmetic has it, for Python's floats too."""
    with np.errstate(all="ignore"):
        return a / (np.float64(b) if isinstance(b, (int, float)) else b)


def _floor(x):
    return dr.floor(x) if dr.is_array_v(x) else np.floor(x)


class Interval:
    """The closed interval [low, high]."""

    __slots__ = ("low", "high")

    def __init__(self, low, high=None):
        self.low = low
        self.high = low if high is None else high

    def __repr__(self):
        return f"{type(self).__name__}({self.low!r}, {self.high!r})"

    # --- rounding --------------------------------------------------------------------------------------------------
    @classmethod
    def rounded(cls, low, high, ulps: int = 1):
        """The interval of two computed bounds, each wrong by at most `ulps` units in the last place."""
        return cls(low, high)

    @classmethod
    def of(cls, number):
        """A thin interval, unless `number` is an interval already."""
        return number if isinstance(number, Interval) else cls(number)

    @property
    def is_thin(self) -> bool:
        """Known, without looking at values, to hold one point only."""
        return self.low is self.high

    # --- what can be concluded -------------------------------------------------------------------------------------
    def excludes_zero(self):
        # (low > 0) | (high < 0), never the negated containment: NaN must not pass for a proof
        return (self.low > 0) | (self.high < 0)

    def hull(self, other):
        other = self.of(other)
        return type(self)(_low(self.low, other.low), _high(self.high, other.high))

    # --- ring ------------------------------------------------------------------------------------------------------
    def __neg__(self):
        return type(self)(-self.high, -self.low)

    def __add__(self, other):
        other = self.of(other)
        return self.rounded(self.low + other.low, self.high + other.high)

    __radd__ = __add__

    def __sub__(self, other):
        other = self.of(other)
        return self.rounded(self.low - other.high, self.high - other.low)

    def __rsub__(self, other):
        return self.of(other) - self

    def __mul__(self, other):
        if other is self:
            return self**2
        if isinstance(other, (int, float)):
            low, high = (self.low, self.high) if other >= 0 else (self.high, self.low)
            return self.rounded(low * other, high * other)
        other = self.of(other)
        if self.is_thin:
            self, other = other, self
        products = [self.low * other.low, self.high * other.low]
        if not other.is_thin:
            products += [self.low * other.high, self.high * other.high]
        return self.rounded(_low(*products), _high(*products))

    __rmul__ = __mul__

    def __truediv__(self, other):
        if isinstance(other, (int, float)) and other:
            low, high = (self.low, self.high) if other > 0 else (self.high, self.low)
            return self.rounded(low / other, high / other)
        other = self.of(other)
        quotients = [_quotient(a, b) for b in (other.low, other.high) for a in (self.low, self.high)]
        safe = other.excludes_zero()
        return self.rounded(fn.select(safe, _low(*quotients), -math.inf), fn.select(safe, _high(*quotients), math.inf))

    def __rtruediv__(self, other):
        return self.of(other) / self

    def __pow__(self, n: int):
        if n < 0:
            return 1.0 / self**-n
        if n == 0:
            return type(self)(self.low * 0.0 + 1.0)
        if n == 1:
            return self
        a, b = self.low**n, self.high**n
        if n % 2:  # monotone
            return self.rounded(a, b, ulps=n)
        straddles = (self.low <= 0) & (self.high >= 0)
        result = self.rounded(fn.select(straddles, 0.0, _low(a, b)), _high(a, b), ulps=n)
        return type(self)(fn.select(result.low >= 0, result.low, 0.0 * result.low), result.high)

    # --- elementary functions --------------------------------------------------------------------------------------
    def _monotone(self, function, ulps):
        return self.rounded(function(self.low), function(self.high), ulps)

    def _whole_line_where(self, undefined, low, high):
        return type(self)(fn.select(undefined, -math.inf, low), fn.select(undefined, math.inf, high))

    def sqrt(self):
        # a low bound of zero that outward rounding has pushed below zero by a subnormal amount is still zero
        low = fn.select(self.low >= 0, self.low, 0.0 * self.high)
        root = self.rounded(fn.sqrt(low), fn.sqrt(fn.maximum(self.high, 0.0 * self.high)))
        low = fn.select(root.low >= 0, root.low, 0.0 * root.high)
        return self._whole_line_where(self.low < -1e-290, low, root.high)

    def cbrt(self):
        return self._monotone(fn.cbrt, ulps=4)

    def exp(self):
        power = self._monotone(fn.exp, ulps=4)
        return type(self)(fn.select(power.low >= 0, power.low, 0.0 * power.low), power.high)

    def log(self):
        # a low bound of zero that outward rounding has pushed below zero by a subnormal amount is still zero
        low = fn.select(self.low > 0, self.low, 1.0)
        logarithm = self.rounded(fn.log(low), fn.log(fn.maximum(self.high, 0.0 * self.high)), ulps=4)
        low = fn.select(self.low > 0, logarithm.low, -math.inf)
        return self._whole_line_where(self.low < -1e-290, low, logarithm.high)

    def sin(self):
        return (self - type(self)(0.5 * _PI)).cos()

    def cos(self):
        # the maximum 1 is taken at 2 k pi, the minimum -1 at (2 k + 1) pi; a margin covers the rounding of pi itself
        margin = 4e-16 + fn.maximum(fn.absolute(self.low), fn.absolute(self.high)) * 4e-16
        low, high = self.low - margin, self.high + margin
        whole = lambda shift: _floor((high - shift) / (2 * _PI)) >= -_floor(-((low - shift) / (2 * _PI)))
        a, b = fn.cos(self.low), fn.cos(self.high)
        return type(self)(_high(fn.select(whole(_PI), -1.0, _low(a, b) - margin), -1.0 + 0.0 * a),
                          _low(fn.select(whole(0.0), 1.0, _high(a, b) + margin), 1.0 + 0.0 * a))

    def tan(self):
        return self.sin() / self.cos()

    def power(self, exponent):
        """Monotone in a base >= 0; the whole line where the base may be negative."""
        if (short := fn.eighths(exponent)) is None:
            power = (self.log() * exponent).exp()
            return self._whole_line_where(~(self.low >= -1e-290), power.low, power.high)
        low = fn.select(self.low >= 0, self.low, 0.0 * self.high)
        a, b = fn.power(low, exponent), fn.power(fn.maximum(self.high, 0.0 * self.high), exponent)
        # u = 2**-53 each: n - 1 products, 4.25 u in at most three roots, 3 products of them, a reciprocal
        power = self.rounded(a, b, short[0] + 4) if exponent > 0 else self.rounded(b, a, short[0] + 4)
        low = fn.select(power.low >= 0, power.low, 0.0 * power.low)
        return self._whole_line_where(~(self.low >= -1e-290), low, power.high)

    def power_of(self, base):
        return self.of(base).power(self)

    def absolute(self):
        return self.maximum(-self)

    def minimum(self, other):
        other = self.of(other)
        return type(self)(_low(self.low, other.low), _low(self.high, other.high))

    def maximum(self, other):
        other = self.of(other)
        return type(self)(_high(self.low, other.low), _high(self.high, other.high))

    def where_larger(self, a, b, if_a, if_b):
        """`if_a` where all of a lies above b, `if_b` where below, the hull of both where they overlap."""
        a, b, if_a, if_b = map(self.of, (a, b, if_a, if_b))
        above, below, both = a.low > b.high, b.low > a.high, if_a.hull(if_b)
        pick = lambda of_a, of_b, of_both: fn.select(above, of_a, fn.select(below, of_b, of_both))
        return type(self)(pick(if_a.low, if_b.low, both.low), pick(if_a.high, if_b.high, both.high))


class OutwardInterval(Interval):
    """An `Interval` whose every operation rounds outwards: what it excludes is excluded as a proof.

    IEEE 754 rounds to nearest, so a computed bound is off by at most half a unit in the last place; moving it by
    |bound| * 2**-52 per stated ulp, and by a subnormal amount, covers that and the rounding of the move.
    """

    __slots__ = ()

    @classmethod
    def rounded(cls, low, high, ulps: int = 1):
        w = ulps * _ULP
        return cls(low - (fn.absolute(low) * w + _TINY), high + (fn.absolute(high) * w + _TINY))
