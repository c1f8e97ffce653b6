"""Number types of python-flint: what a surface's f is evaluated on when it has to be decided, not approximated.

`RationalPolynomial` is the ray polynomial g(t) with exact rational coefficients; floats enter it as the dyadic
numbers they are. `Series` is the Taylor polynomial of g about a ball of t (Johansson 2017, Arb), for any other f.
"""

from __future__ import annotations

from flint import arb, arb_series, fmpq, fmpq_poly

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
        return RationalPolynomial(self.p * (1 / divisor))

    def __rtruediv__(self, other):
        return RationalPolynomial.constant(other) / self

    def __pow__(self, n: int):
        return RationalPolynomial(self.p**n) if n >= 0 else 1 / self**-n

    def _not_algebraic(self, *_):
        raise NotAlgebraic("a function that is not a polynomial")

    sqrt = cbrt = sin = cos = tan = exp = log = absolute = minimum = maximum = _not_algebraic


class Series:
    """Balls that enclose a function's value, first and half its second derivative for every t of a ball.

    Where a function has a kink inside the ball the second derivative is NaN and the first one the hull of both
    slopes; where it is not defined everything is NaN. From NaN nothing is ever concluded. Precision is flint's
    `ctx.prec`, length `ctx.cap` = ORDER: see certify/search.py.
    """

    __slots__ = ("s",)

    def __init__(self, s: arb_series):
        self.s = s

    @classmethod
    def constant(cls, value) -> Series:
        return cls(arb_series([cls._coefficient(value)]))

    @classmethod
    def along(cls, origin, direction, t) -> tuple[Series, ...]:
        """The three coordinates of origin + t direction, all of them balls."""
        return tuple(cls(arb_series([o + t * d, d])) for o, d in zip(origin, direction))

    @staticmethod
    def _coefficient(value) -> arb:
        return value if isinstance(value, arb) else arb(rational(value))

    @classmethod
    def _of(cls, other) -> arb_series:
        return other.s if isinstance(other, Series) else arb_series([cls._coefficient(other)])

    def __neg__(self):
        return Series(-self.s)

    def __add__(self, other):
        return Series(self.s + self._of(other))

    __radd__ = __add__

    def __sub__(self, other):
        return Series(self.s - self._of(other))

    def __rsub__(self, other):
        return Series(self._of(other) - self.s)

    def __mul__(self, other):
        return self**2 if other is self else Series(self.s * self._of(other))

    __rmul__ = __mul__

    def __truediv__(self, other):
        return Series(self.s / self._of(other))

    def __rtruediv__(self, other):
        return Series(self._of(other) / self.s)

    def __pow__(self, n: int):
        if n < 0:
            return 1 / self**-n
        power = arb_series([arb(1)])
        for _ in range(n):
            power = power * self.s
        if n and n % 2 == 0:  # a product of a ball with itself does not know that a square is not negative
            power = arb_series([power[0].nonnegative_part(), *(power[k] for k in range(1, ORDER))])
        return Series(power)

    # --- elementary functions --------------------------------------------------------------------------------------
    def sqrt(self):
        return Series(self.s.sqrt())

    def sin(self):
        return Series(self.s.sin())

    def cos(self):
        return Series(self.s.cos())

    def tan(self):
        return Series(self.s.tan())

    def exp(self):
        return Series(self.s.exp())

    def log(self):
        return Series(self.s.log())

    def cbrt(self):
        value = self.s[0]
        if value > 0:
            return Series((self.s.log() / 3).exp())
        if value < 0:
            return -((-self).cbrt())
        low, high = value.lower(), value.upper()  # the slope is infinite at zero
        root = lambda v: v.root(3) if v >= 0 else -((-v).root(3))
        hull = root(low).union(root(high)) if value.is_finite() else arb.nan()
        return Series(arb_series([hull, arb.nan(), arb.nan()]))

    def absolute(self):
        return self.maximum(-self)

    def minimum(self, other):
        return -((-self).maximum(-Series(self._of(other))))

    def maximum(self, other):
        a, b = self.s, self._of(other)
        if a[0] >= b[0]:
            return Series(a)
        if b[0] >= a[0]:
            return Series(b)
        return Series(arb_series([a[0].max(b[0]), a[1].union(b[1]), arb.nan()]))
