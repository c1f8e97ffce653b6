"""Interval arithmetic: f of an interval encloses every value f takes on it (Moore, Interval Analysis, 1966).

`Interval` rounds to nearest: an enclosure up to rounding, which is enough to miss no root in practice and costs least.
`OutwardInterval` widens every result by the units in the last place it may be wrong by: an enclosure that holds as a proof.
Bounds may be floats, NumPy or Dr.Jit arrays.

Where a pole lies in the interval the result is the whole line, [-inf, inf]. Where an operation is undefined somewhere (a
square root below zero) both bounds are NaN. A bound that is NaN bounds nothing: comparisons with it are false, so nothing
is concluded, and every operation hands it on, also those whose values are bounded (a cosine, the smaller of two): f is not
known to exist there (M7). inf - inf and 0 inf make such bounds, too, where numbers overflow. In `Interval` a lower bound of
+inf or an upper one of -inf is one beyond the largest float.

Subnormal numbers: Dr.Jit's threads read and write them as zero. Results that underflow are covered; subnormal bounds that
enter from outside, in arrays, count as what the threads read.

`make enclosures` holds every function against python-flint and measures every constant here.
"""

from __future__ import annotations

import math

import drjit as dr
import numpy as np

from . import functions as fn
from .jumps import side

_PI = math.pi
_ULP = 2.0**-52  # one unit in the last place of 1.0, fp64
_SMALLEST_NORMAL = 2.0**-1022  # what is smaller may be flushed to zero
_TINY = 2 * _SMALLEST_NORMAL  # a result that underflows is wrong by less than half of it; the rest covers the move itself
_LARGEST = np.finfo(np.float64).max.item()

# Units in the last place by which a function of floats may be wrong; at least twice what the command above finds.
ULPS = {"sqrt": 1, "cbrt": 4, "exp": 4, "log": 4, "atan2": 12}
# Of sine and cosine up to LARGEST_ANGLE, absolute, since near their zeros Dr.Jit's relative error is large; 2**-53 of it
# covers the rounding of the bound that is moved by it.
WAVE_ERROR = 4e-16
# Which multiple of a period is next to x follows from (x - shift) / period: wrong by |x| 2**-53 times 4 (two differences,
# the product, 1 / period as a float) and by the shift's own rounding, below 2**-53 times 2.
ANGLE_ERROR = 6e-16
_HALF_TURN = math.nextafter(_PI, 4)  # pi as a float is below pi
STEEPEST = 2.0**20  # |tan| above which WAVE_ERROR (1 + |tan|) is no longer small


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


def _both(a, b):
    """a and b, each a Python bool, known while recording, or an array of them."""
    return b if a is True else a if b is True else False if a is False or b is False else a & b


def _either(a, b):
    return b if a is False else a if b is False else True if a is True or b is True else a | b


def _floor(x):
    return dr.floor(x) if dr.is_array_v(x) else np.floor(x)


class Interval:
    """The closed interval [low, high].

    `nonnegative` (bool or Bool) tells that no number below zero is meant, though rounding may have pushed `low` there: a
    sum of squares is defined under a square root.
    """

    __slots__ = ("low", "high", "nonnegative")

    def __init__(self, low, high=None, nonnegative=False):
        self.low = low
        self.high = low if high is None else high
        self.nonnegative = nonnegative

    def __repr__(self):
        return f"{type(self).__name__}({self.low!r}, {self.high!r})"

    # --- rounding --------------------------------------------------------------------------------------------------
    @classmethod
    def rounded(cls, low, high, ulps: int = 1, nonnegative=False):
        """The interval of two computed bounds, each wrong by at most `ulps` units in the last place."""
        return cls(low, high, nonnegative)

    @classmethod
    def of(cls, number):
        """A thin interval, unless `number` is an interval already."""
        if isinstance(number, Interval):
            return number
        return cls(number, nonnegative=number >= 0)

    @property
    def is_thin(self) -> bool:
        """Known, without looking at values, to hold one point only."""
        return self.low is self.high

    def _not_negative(self):
        """The same interval, of numbers that are not negative."""
        return type(self)(self.low, self.high, True)

    def of_sign(self, *parts):
        """The same interval; it is not negative where the product of `parts` is not."""
        above, below = True, False  # whether the product so far is >= 0, <= 0
        for part in map(self.of, parts):
            up, down = _either(part.nonnegative, part.low >= 0), part.high <= 0
            above, below = (_either(_both(above, up), _both(below, down)), _either(_both(above, down), _both(below, up)))
        return type(self)(self.low, self.high, _either(self.nonnegative, above))

    def _finite_inside(self):
        """The same interval, its lower bound not +inf and its upper one not -inf."""
        return type(self)(fn.minimum(self.low, _LARGEST), fn.maximum(self.high, -_LARGEST), self.nonnegative)

    # --- what can be concluded -------------------------------------------------------------------------------------
    def excludes_zero(self):
        # (low > 0) | (high < 0), never the negated containment: NaN must not pass for a proof
        return (self.low > 0) | (self.high < 0)

    def hull(self, other):
        other = self.of(other)
        return type(self)(_low(self.low, other.low), _high(self.high, other.high),
                          _both(self.nonnegative, other.nonnegative))

    # --- ring ------------------------------------------------------------------------------------------------------
    def __neg__(self):
        return type(self)(-self.high, -self.low)

    def __add__(self, other):
        other = self.of(other)
        return self.rounded(self.low + other.low, self.high + other.high,
                            nonnegative=_both(self.nonnegative, other.nonnegative))

    __radd__ = __add__

    def __sub__(self, other):
        other = self.of(other)
        return self.rounded(self.low - other.high, self.high - other.low)

    def __rsub__(self, other):
        return self.of(other) - self

    def __mul__(self, other):
        if other is self:
            return self**2
        if _is_plain(other):
            low, high = (self.low, self.high) if other >= 0 else (self.high, self.low)
            return self.rounded(low * other, high * other, nonnegative=_both(self.nonnegative, other >= 0))
        other = self.of(other)
        if self.is_thin:
            self, other = other, self
        products = [self.low * other.low, self.high * other.low]
        if not other.is_thin:
            products += [self.low * other.high, self.high * other.high]
        return self.rounded(_low(*products), _high(*products), nonnegative=_both(self.nonnegative, other.nonnegative))

    __rmul__ = __mul__

    def __truediv__(self, other):
        if _is_plain(other) and other:
            low, high = (self.low, self.high) if other > 0 else (self.high, self.low)
            return self.rounded(low / other, high / other, nonnegative=_both(self.nonnegative, other > 0))
        other = self.of(other)._finite_inside()
        quotients = [fn.quotient(a, b) for b in (other.low, other.high) for a in (self.low, self.high)]
        safe = other.excludes_zero()
        quotient = self.rounded(_low(*quotients), _high(*quotients))
        anything = fn.select((self.low <= self.high) & (other.low <= other.high), math.inf, math.nan)
        return self._where(safe, quotient, anything, _both(self.nonnegative, other.nonnegative))

    def __rtruediv__(self, other):
        return self.of(other) / self

    def __pow__(self, n: int):
        if n < 0:
            return 1.0 / self**-n
        if n == 0:
            return type(self)(self.low * 0.0 + 1.0, nonnegative=True)
        if n == 1:
            return self
        a, b = fn.whole_power(self.low, n), fn.whole_power(self.high, n)
        if n % 2:  # monotone
            return self.rounded(a, b, n, self.nonnegative)
        straddles = (self.low <= 0) & (self.high >= 0)
        return self.rounded(fn.select(straddles, 0.0, _low(a, b)), _high(a, b), n)._not_negative()

    # --- elementary functions --------------------------------------------------------------------------------------
    @classmethod
    def _where(cls, holds, result, other=math.nan, nonnegative=False):
        """`result` where `holds`, elsewhere [-other, other]."""
        return cls(fn.select(holds, result.low, -other), fn.select(holds, result.high, other), nonnegative)

    def _increasing(self, function, ulps, nonnegative=False):
        self = self._finite_inside()
        return self.rounded(function(self.low), function(self.high), ulps, nonnegative)

    def _above_zero(self, of_nonnegative, nonnegative=False):
        """`of_nonnegative` of the part above zero, undefined where there may be another part."""
        part = type(self)(fn.select(self.low >= 0, self.low, 0.0), fn.maximum(self.high, 0.0), True)._finite_inside()
        result = of_nonnegative(part)
        if self.nonnegative is True:
            return result
        defined = _either(self.nonnegative, self.low >= 0)
        return self._where(defined, result, nonnegative=_both(nonnegative, defined))

    def sqrt(self):
        return self._above_zero(lambda part: part.rounded(fn.sqrt(part.low), fn.sqrt(part.high), ULPS["sqrt"])
                                ._not_negative(), True)

    def cbrt(self):
        return self._increasing(fn.cbrt, ULPS["cbrt"], self.nonnegative)

    def exp(self):
        return self._increasing(fn.exp, ULPS["exp"])._not_negative()

    def log(self):
        return self._above_zero(lambda part: part.rounded(fn.log(part.low), fn.log(part.high), ULPS["log"]))

    def power(self, exponent):
        """Monotone in a base >= 0; undefined where the base may be negative."""
        return self._above_zero(lambda part: part._power(exponent)._not_negative(), True)

    def _power(self, exponent):
        if (short := fn.eighths(exponent)) is None:
            return (self.log() * exponent).exp()
        a, b = fn.power(self.low, exponent), fn.power(self.high, exponent)
        # in units of 2**-53: n - 1 products, 4.25 in at most three roots, 3 products of them, a reciprocal
        return self.rounded(a, b, short[0] + 4) if exponent > 0 else self.rounded(b, a, short[0] + 4)

    def power_of(self, base):
        """base ** self."""
        return self.of(base).power(self)

    def sin(self):
        return self._wave(fn.sin, 0.5 * _PI)

    def cos(self):
        return self._wave(fn.cos, 0.0)

    def _reach(self):
        return fn.maximum(fn.absolute(self.low), fn.absolute(self.high))

    def _holds(self, angle, period, reach):
        """Whether some angle + k period may lie in the interval (Bool)."""
        margin = ANGLE_ERROR * (1 + reach)
        first = (self.low - margin - angle) * (1 / period)
        last = (self.high + margin - angle) * (1 / period)
        return _floor(last) >= -_floor(-first)

    def _wave(self, function, top):
        """Sine or cosine, whose maximum 1 lies at top + 2 k pi, its minimum -1 half a period further."""
        reach = self._reach()
        a, b = function(self.low), function(self.high)
        known = reach <= fn.LARGEST_ANGLE
        falls_to, rises_to = fn.maximum(_low(a, b) - WAVE_ERROR, -1.0), fn.minimum(_high(a, b) + WAVE_ERROR, 1.0)
        valley, peak = self._holds(top + _PI, 2 * _PI, reach), self._holds(top, 2 * _PI, reach)
        most = fn.select(reach <= math.inf, 1.0, math.nan)
        return type(self)(fn.select(known, fn.select(valley, -1.0, falls_to), -most),
                          fn.select(known, fn.select(peak, 1.0, rises_to), most))

    def tan(self):
        """Increasing between its poles. Sine and cosine wrong by e make it wrong by e (1 + |tan|) / |cos| to first order,
        and 1 / |cos| <= 1 + |tan|; twice that is granted."""
        reach = self._reach()
        a, b = fn.tan(self.low), fn.tan(self.high)
        steepest = fn.maximum(fn.absolute(a), fn.absolute(b))
        error = 2 * WAVE_ERROR * (1 + steepest) * (1 + steepest)
        pole = self._holds(0.5 * _PI, _PI, reach)
        known = (reach <= fn.LARGEST_ANGLE) & (steepest <= STEEPEST)
        return self._where(fn.select(pole, False, known), self.rounded(a - error, b + error),
                           fn.select(reach <= math.inf, math.inf, math.nan))

    def absolute(self):
        return type(self)(_high(self.low, -self.high, 0.0), _high(self.high, -self.low), True)

    def floor(self):
        return type(self)(*side(fn.floor(self.low), fn.floor(self.high)), self.nonnegative)

    def heaviside(self):
        return type(self)(*side(fn.heaviside(self.low), fn.heaviside(self.high)), True)

    def flat_slope(self, function):
        """See functions.flat_slope."""
        low, high = function(self.low), function(self.high)
        slope = fn.select(low == high, 0.0 * low, math.nan)  # of two Python numbers dr.select makes single precision
        return type(self)(slope, slope)

    def atan2(self, x):
        """Monotone along both axes, so that the corners of a box hold the extremes, unless it meets the cut or the origin."""
        x = self.of(x)
        corners = [fn.atan2(b, a) for b in (self.low, self.high) for a in (x.low, x.high)]
        angle = self.rounded(_low(*corners), _high(*corners), ULPS["atan2"], self.nonnegative)
        whole = fn.select((self.low <= self.high) & (x.low <= x.high), 0.0 * corners[0] + _HALF_TURN, math.nan)
        return self._where(~self._meets_cut(x), angle, whole, self.nonnegative)

    def atan2_of(self, y):
        return self.of(y).atan2(self)

    def _meets_cut(self, x):
        # a bound that is NaN meets everything
        return ~((self.low > 0) | (self.high < 0) | (x.low > 0))

    def off_cut(self, x):
        """0 where the box of ordinates `self` and abscissas `x` holds no point at which the angle jumps, else NaN."""
        x = self.of(x)
        slope = fn.select(self._meets_cut(x), math.nan, 0.0 * fn.atan2(self.low, x.low))
        return type(self)(slope, slope)

    def minimum(self, other):
        other = self.of(other)
        return type(self)(_low(self.low, other.low), _low(self.high, other.high), _both(self.nonnegative, other.nonnegative))

    def maximum(self, other):
        other = self.of(other)
        return type(self)(_high(self.low, other.low), _high(self.high, other.high),
                          _either(self.nonnegative, other.nonnegative))

    def where_larger(self, a, b, if_a, if_b):
        """`if_a` where all of a lies above b, `if_b` where below, the hull of both where they overlap."""
        a, b, if_a, if_b = map(self.of, (a, b, if_a, if_b))
        above, below, both = a.low > b.high, b.low > a.high, if_a.hull(if_b)
        # of two Python numbers dr.select makes one of single precision
        lifted = dr.expr_t(a.low, b.low) if dr.is_array_v(a.low) or dr.is_array_v(b.low) else lambda bound: bound
        pick = lambda of_a, of_b, of_both: fn.select(above, lifted(of_a), fn.select(below, lifted(of_b), lifted(of_both)))
        return type(self)(pick(if_a.low, if_b.low, both.low), pick(if_a.high, if_b.high, both.high), both.nonnegative)


def _is_plain(number) -> bool:
    """A Python number that arithmetic can take as it is: Dr.Jit's threads read subnormal ones as zero."""
    return isinstance(number, (int, float)) and (number == 0 or abs(number) >= _SMALLEST_NORMAL)


class OutwardInterval(Interval):
    """An `Interval` whose every operation rounds outwards: what it excludes is excluded as a proof.

    IEEE 754 rounds to nearest, so a computed bound is off by at most half a unit in the last place; moving it by
    |bound| * 2**-52 per stated ulp, and by a subnormal amount, covers that and the rounding of the move. A lower bound that
    overflows to +inf, an upper one to -inf, becomes NaN by this move: open.
    """

    __slots__ = ()

    @classmethod
    def rounded(cls, low, high, ulps: int = 1, nonnegative=False):
        w = ulps * _ULP
        return cls(low - (fn.absolute(low) * w + _TINY), high + (fn.absolute(high) * w + _TINY), nonnegative)

    @classmethod
    def of(cls, number):
        if isinstance(number, (int, float)) and not _is_plain(number) and number == number:  # subnormal
            return cls(0.0, _SMALLEST_NORMAL, True) if number > 0 else cls(-_SMALLEST_NORMAL, 0.0)
        return super().of(number)

    def _not_negative(self):
        return type(self)(fn.select(self.low < 0, 0.0, self.low), self.high, True)

    def _finite_inside(self):
        return self


class DefinedPart(OutwardInterval):
    """An `OutwardInterval` of the values that f takes where it is defined (a loose evaluation in IEEE 1788's sense).

    Square roots, logarithms and powers are those of the part of their argument in their domain. Where there is none, no
    number is above `low` and below `high`: low > high, from [inf, -inf] on through sums and extrema.
    """

    __slots__ = ()

    @classmethod
    def rounded(cls, low, high, ulps: int = 1, nonnegative=False):
        moved = super().rounded(low, high, ulps, nonnegative)
        return cls(fn.select(low == math.inf, math.inf, moved.low), fn.select(high == -math.inf, -math.inf, moved.high),
                   nonnegative)

    def _above_zero(self, of_nonnegative, nonnegative=False):
        low = fn.select(self.low >= 0, self.low, 0.0 * self.low)  # NaN where the interval is, or has no lower bound
        result = of_nonnegative(type(self)(low, fn.maximum(self.high, 0.0), True))
        nowhere = self.high < 0
        return type(self)(fn.select(nowhere, math.inf, result.low), fn.select(nowhere, -math.inf, result.high), nonnegative)
