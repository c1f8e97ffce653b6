"""Number types of python-flint: what a surface's f is evaluated on when it has to be decided, not approximated.

`RationalPolynomial` is the ray polynomial g(t) with exact rational coefficients; floats enter it as the dyadic
numbers they are. `Series` is the Taylor polynomial of g about a ball of t (Johansson 2017, Arb), for any other f.
"""

from __future__ import annotations

import math

from flint import arb, arb_series, fmpq, fmpq_poly

from .jumps import side
from .polynomial import NotAlgebraic

ORDER = 3  # coefficients of a Series: value, first derivative, half the second


def rational(value) -> fmpq:
    """The rational number that a float, an int, an fmpq or the midpoint of an arb is, exactly."""
    if isinstance(value, fmpq):
        return value
    if isinstance(value, arb):
        return value.mid().fmpq()
    return fmpq(value) if isinstance(value, int) else fmpq(*float(value).as_integer_ratio())


class RationalPolynomial:
    """A polynomial in t with rational coefficients, `p` (fmpq_poly)."""

    __slots__ = ("p",)

    def __init__(self, p: fmpq_poly):
        self.p = p

    @classmethod
    def constant(cls, value) -> RationalPolynomial:
        return cls(fmpq_poly([rational(value)]))

    @classmethod
    def along(cls, origin, direction) -> tuple[RationalPolynomial, ...]:
        """The three coordinates of origin + t direction."""
        return tuple(cls(fmpq_poly([rational(o), rational(d)])) for o, d in zip(origin, direction))

    @staticmethod
    def _of(other):
        return other.p if isinstance(other, RationalPolynomial) else rational(other)

    def __neg__(self):
        return RationalPolynomial(-self.p)

    def __add__(self, other):
        return RationalPolynomial(self.p + self._of(other))

    __radd__ = __add__

    def __sub__(self, other):
        return RationalPolynomial(self.p - self._of(other))

    def __rsub__(self, other):
        return RationalPolynomial(self._of(other) - self.p)

    def __mul__(self, other):
        return RationalPolynomial(self.p * self._of(other))

    __rmul__ = __mul__

    def __truediv__(self, other):
        divisor = self._of(other)
        if isinstance(divisor, fmpq_poly):
            if divisor.degree() > 0:
                raise NotAlgebraic("division by a function of the coordinates")
            divisor = divisor[0]
        if divisor == 0:
            raise NotAlgebraic("division by zero")
        return RationalPolynomial(self.p * (1 / divisor))

    def __rtruediv__(self, other):
        return RationalPolynomial.constant(other) / self

    def __pow__(self, n: int):
        return RationalPolynomial(self.p**n) if n >= 0 else 1 / self**-n

    def _not_algebraic(self, *_):
        raise NotAlgebraic("a function that is not a polynomial")

    sqrt = cbrt = sin = cos = tan = exp = log = absolute = power = power_of = minimum = maximum = _not_algebraic
    floor = heaviside = atan2 = atan2_of = _not_algebraic


class Series:
    """Balls that enclose a function's value, first and half its second derivative for every t of a ball.

    Where a derivative does not exist somewhere in the ball it is NaN, at a kink the first one is the hull of both
    slopes; where the function is not defined everything is NaN. From NaN nothing is ever concluded. `nonnegative` tells
    that the value is known not to be negative, which a ball around zero cannot say of itself. Precision is flint's
    `ctx.prec`, length `ctx.cap` = ORDER: see certify/search.py.
    """

    __slots__ = ("s", "nonnegative")

    def __init__(self, s: arb_series, nonnegative: bool = False):
        self.s, self.nonnegative = s, nonnegative

    @classmethod
    def constant(cls, value) -> Series:
        ball = value if isinstance(value, arb) else arb(rational(value))
        return cls(arb_series([ball]), bool(ball >= 0))

    @classmethod
    def along(cls, origin, direction, t) -> tuple[Series, ...]:
        """The three coordinates of origin + t direction, all of them balls."""
        return tuple(cls(arb_series([o + t * d, d])) for o, d in zip(origin, direction))

    @classmethod
    def _of(cls, other) -> Series:
        return other if isinstance(other, Series) else cls.constant(other)

    def __neg__(self):
        return Series(-self.s)

    def __add__(self, other):
        other = self._of(other)
        return Series(self.s + other.s, self.nonnegative and other.nonnegative)

    __radd__ = __add__

    def __sub__(self, other):
        return Series(self.s - self._of(other).s)

    def __rsub__(self, other):
        return self._of(other) - self

    def __mul__(self, other):
        if other is self:
            return self**2
        other = self._of(other)
        return Series(self.s * other.s, self.nonnegative and other.nonnegative)

    __rmul__ = __mul__

    def __truediv__(self, other):
        other = self._of(other)
        if other.s[0].contains(0) or not other.s[0].is_finite():
            return self._undefined()
        return Series(self.s / other.s, self.nonnegative and other.nonnegative)

    def __rtruediv__(self, other):
        return self._of(other) / self

    def __pow__(self, n: int):
        if n < 0:
            return 1 / self**-n
        power = arb_series([arb(1)])
        for _ in range(n):
            power = power * self.s
        return Series(power, n % 2 == 0 or self.nonnegative)

    def of_sign(self, *parts):
        """The same; not negative where the product of `parts` is not."""
        signs = [1 if part.nonnegative else -1 if part.s[0] <= 0 else 0 for part in map(self._of, parts)]
        return Series(self.s, self.nonnegative or math.prod(signs) > 0)

    # --- elementary functions --------------------------------------------------------------------------------------
    @staticmethod
    def _undefined() -> Series:
        return Series(arb_series([arb.nan()] * ORDER))

    @staticmethod
    def _cusp(low: arb, high: arb, nonnegative: bool) -> Series:
        """A value between low and high without derivatives."""
        return Series(arb_series([low.union(high), arb.nan(), arb.nan()]), nonnegative)

    def sqrt(self):
        if self.nonnegative and self.s[0].contains(0):
            return self._cusp(arb(0), self.s[0].upper().sqrt(), True)
        return Series(self.s.sqrt(), True)

    def cbrt(self):
        value = self.s[0]
        if value > 0:
            return Series((self.s.log() / 3).exp(), True)
        if value < 0:
            return -((-self).cbrt())
        if not value.is_finite():
            return self._undefined()
        low = arb(0) if self.nonnegative else value.lower()
        root = lambda v: v.root(3) if v > 0 else -((-v).root(3)) if v < 0 else arb(0)
        return self._cusp(root(low), root(value.upper()), self.nonnegative)

    def sin(self):
        return Series(self.s.sin())

    def cos(self):
        return Series(self.s.cos())

    def tan(self):
        return Series(self.s.tan())

    def exp(self):
        return Series(self.s.exp(), True)

    def log(self):
        return Series(self.s.log())

    def power(self, exponent):
        """self ** exponent; over a ball that reaches 0, the derivatives that exist there for a constant exponent."""
        exponent = self._of(exponent)
        base, p = self.s[0], exponent.s[0]
        constant = all(c == 0 for c in exponent.s.coeffs()[1:])
        if base > 0:
            return Series((self.s.log() * exponent.s).exp(), True)
        if not (self.nonnegative and base.is_finite() and p > 0):
            return self._undefined()
        low, high = arb(0), base.upper()
        ball = lambda q: low.union(high**q) if q > 0 else arb(1) if q == 0 else arb.nan()  # of base ** q
        if not constant:
            return self._cusp(low, (arb(high).max(arb(1)))**p.upper() if high > 1 else high**p.lower(), True)
        first = p * ball(p - 1)
        second = p * (p - 1) * ball(p - 2) / 2
        a1, a2 = self.s[1], self.s[2]
        return Series(arb_series([ball(p), first * a1, first * a2 + second * a1 * a1]), True)

    def power_of(self, base):
        return self._of(base).power(self)

    def absolute(self):
        return Series(self.maximum(-self).s, True)

    def floor(self):
        return self._stairs(arb.floor, self.nonnegative)

    def heaviside(self):
        return self._stairs(lambda v: arb(0) if v < 0 else arb(1), True)

    def _stairs(self, function, nonnegative: bool) -> Series:
        """Of a function that is constant between its jumps upwards."""
        if not self.s[0].is_finite():
            return self._undefined()
        low, high = function(self.s[0].lower()), function(self.s[0].upper())
        if low == high:
            return Series(arb_series([low]), nonnegative)
        return self._cusp(*side(low, high, lambda holds, a, b: a if holds else b), nonnegative)

    def hull(self, other) -> Series:
        """Of the values; nothing is known of derivatives."""
        return self._cusp(self.s[0], other.s[0], self.nonnegative and other.nonnegative)

    def atan2(self, x):
        x = self._of(x)
        if x.s[0] > 0:
            return Series((self.s / x.s).atan(), self.nonnegative)
        if self.s[0] > 0 or self.s[0] < 0:
            quarter = arb.pi() / 2 if self.s[0] > 0 else -arb.pi() / 2
            return Series(arb_series([quarter]) - (x.s / self.s).atan(), self.nonnegative)
        if not (self.s[0].is_finite() and x.s[0].is_finite()):
            return self._undefined()
        return self._cusp(-arb.pi().upper(), arb.pi().upper(), self.nonnegative)  # the cut or the origin

    def atan2_of(self, y):
        return self._of(y).atan2(self)

    def minimum(self, other):
        other = self._of(other)
        return Series((-((-self).maximum(-other))).s, self.nonnegative and other.nonnegative)

    def maximum(self, other):
        other = self._of(other)
        a, b = self.s, other.s
        if a[0] >= b[0]:
            return self
        if b[0] >= a[0]:
            return other
        hull = arb_series([a[0].max(b[0]), a[1].union(b[1]), arb.nan()])
        return Series(hull, self.nonnegative or other.nonnegative)
