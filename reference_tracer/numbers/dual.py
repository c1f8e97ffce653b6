"""Dual numbers: a value with its first derivatives along chosen directions (forward differentiation).

a + a' eps with eps**2 = 0. One direction along the ray gives g(t) and g'(t) for Newton (section 4.2); three axes give
the gradient for the normal (section 4.3). Coefficients may be floats, arrays or intervals.
"""

from __future__ import annotations

from dataclasses import dataclass

from . import functions as fn


@dataclass(frozen=True, slots=True)
class Dual:
    """`value` and the tuple `derivatives`; an entry None is a derivative known to be zero and costs nothing."""

    value: object
    derivatives: tuple

    @staticmethod
    def along(origin, direction):
        """The point origin + t*direction at t = 0 as three duals in one variable t."""
        return tuple(Dual(o, (d,)) for o, d in zip(origin, direction))

    @staticmethod
    def axes(point):
        """The three coordinates of `point` as independent variables: f of them carries grad f."""
        return tuple(Dual(p, tuple(1.0 if i == k else None for i in range(3))) for k, p in enumerate(point))

    def derivative(self, i: int = 0):
        d = self.derivatives[i]
        return 0.0 * self.value if d is None else d

    # --- ring ------------------------------------------------------------------------------------------------------
    def _chain(self, value, slope):
        """phi(self): the value phi(a) and the derivatives phi'(a) a'."""
        return Dual(value, tuple(_times(d, slope) for d in self.derivatives))

    def __neg__(self):
        return Dual(-self.value, tuple(None if d is None else -d for d in self.derivatives))

    def __add__(self, other):
        if not isinstance(other, Dual):
            return Dual(self.value + other, self.derivatives)
        return Dual(self.value + other.value, tuple(map(_plus, self.derivatives, other.derivatives)))

    __radd__ = __add__

    def __sub__(self, other):
        return self + (-other)

    def __rsub__(self, other):
        return (-self) + other

    def __mul__(self, other):
        if not isinstance(other, Dual):
            return Dual(self.value * other, tuple(_times(d, other) for d in self.derivatives))
        if other is self:
            return self**2
        return Dual(self.value * other.value,
                    tuple(_plus(_times(da, other.value), _times(db, self.value))
                          for da, db in zip(self.derivatives, other.derivatives)))

    __rmul__ = __mul__

    def __truediv__(self, other):
        if not isinstance(other, Dual):
            return Dual(fn.quotient(self.value, other), tuple(_over(d, other) for d in self.derivatives))
        quotient = fn.quotient(self.value, other.value)
        return Dual(quotient, tuple(_over(_plus(da, _times(_negative(db), quotient)), other.value)
                                    for da, db in zip(self.derivatives, other.derivatives)))

    def __rtruediv__(self, other):
        value = fn.quotient(other, self.value)
        return self._chain(value, -fn.quotient(value, self.value))

    def __pow__(self, n: int):
        if n == 0:
            return Dual(self.value**0, (None,) * len(self.derivatives))
        if n == 1:
            return self
        if n < 0:
            return 1.0 / self**-n
        return self._chain(fn.whole_power(self.value, n), n * fn.whole_power(self.value, n - 1))

    def of_sign(self, *parts):
        return Dual(fn.of_sign(self.value, *(part.value if isinstance(part, Dual) else part for part in parts)),
                    self.derivatives)

    # --- elementary functions --------------------------------------------------------------------------------------
    def sqrt(self):
        root = fn.sqrt(self.value)
        return self._chain(root, fn.quotient(0.5, root))

    def cbrt(self):
        root = fn.cbrt(self.value)
        return self._chain(root, fn.quotient(1.0 / 3.0, root**2))

    def sin(self):
        return self._chain(fn.sin(self.value), fn.cos(self.value))

    def cos(self):
        return self._chain(fn.cos(self.value), -fn.sin(self.value))

    def tan(self):
        tangent = fn.tan(self.value)
        return self._chain(tangent, 1.0 + tangent**2)

    def exp(self):
        power = fn.exp(self.value)
        return self._chain(power, power)

    def log(self):
        return self._chain(fn.log(self.value), fn.quotient(1.0, self.value))

    def power(self, exponent):
        if not isinstance(exponent, Dual):
            # p a**(p - 1), never p a**p / a: at a = 0 the slope is 0 for p > 1
            return self._chain(fn.power(self.value, exponent),
                               fn.power(self.value, fn.less_one(exponent, self.value)) * exponent)
        power = fn.power(self.value, exponent.value)
        of_base = fn.power(self.value, fn.less_one(exponent.value, self.value)) * exponent.value
        of_exponent = fn.times_log(power, self.value)
        return Dual(power, tuple(_plus(_times(da, of_base), _times(db, of_exponent))
                                 for da, db in zip(self.derivatives, exponent.derivatives)))

    def power_of(self, base):
        """base ** self for a base without derivatives."""
        power = fn.power(base, self.value)
        return self._chain(power, fn.times_log(power, base))

    def absolute(self):
        # intervals across the kink keep both slopes
        return Dual(fn.absolute(self.value), tuple(None if d is None else fn.where_larger(self.value, 0.0, d, -d)
                                                   for d in self.derivatives))

    def floor(self):
        return self._chain(fn.floor(self.value), fn.flat_slope(fn.floor, self.value))

    def heaviside(self):
        return self._chain(fn.heaviside(self.value), fn.flat_slope(fn.heaviside, self.value))

    def atan2(self, x):
        """The angle of (x, self); over a box that meets the cut its slopes are NaN, as over any jump."""
        x = x if isinstance(x, Dual) else Dual(x, (None,) * len(self.derivatives))
        off_cut = getattr(self.value, "off_cut", lambda x: 0.0)(x.value)
        square = fn.add(self.value**2, x.value**2)
        to_y, to_x = (fn.add(fn.quotient(v, square), off_cut) for v in (x.value, -self.value))
        return Dual(fn.atan2(self.value, x.value),
                    tuple(_plus(_times(dy, to_y), _times(dx, to_x)) for dy, dx in zip(self.derivatives, x.derivatives)))

    def atan2_of(self, y):
        return Dual(y, (None,) * len(self.derivatives)).atan2(self)

    def minimum(self, other):
        return -((-self).maximum(-other))

    def maximum(self, other):
        other = other if isinstance(other, Dual) else Dual(other, (None,) * len(self.derivatives))
        return Dual(fn.maximum(self.value, other.value),
                    tuple(None if da is None and db is None
                          else fn.where_larger(self.value, other.value, _or_zero(da), _or_zero(db))
                          for da, db in zip(self.derivatives, other.derivatives)))


def _or_zero(d):
    return 0.0 if d is None else d


def _negative(d):
    return None if d is None else -d


def _plus(a, b):
    return b if a is None else a if b is None else fn.add(a, b)


def _times(d, factor):
    return None if d is None else fn.mul(d, factor)  # d may be an array, a parameter times the slope 1


def _over(d, divisor):
    return None if d is None else fn.quotient(d, divisor)
