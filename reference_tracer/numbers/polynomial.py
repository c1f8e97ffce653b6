"""Polynomials in one variable t: f of the ray origin + t*direction, for a surface f that is algebraic.

Evaluating f(x, y, z) on three linear polynomials gives the ray's polynomial g(t) with all its coefficients; the
degree of f falls out the same way. Division by a polynomial, roots and transcendental functions do not exist here:
a surface that uses them is not algebraic in this form (`NotAlgebraic`).
"""

from __future__ import annotations

from dataclasses import dataclass

from . import functions as fn

HIGHEST_DEGREE = 64


class NotAlgebraic(TypeError):
    """The function is not a polynomial of its coordinates."""


@dataclass(frozen=True, slots=True)
class Polynomial:
    """c[0] + c[1] t + ... + c[n] t**n; coefficients are floats, arrays, intervals or exact rationals."""

    c: tuple

    @staticmethod
    def along(origin, direction):
        """The three coordinates of origin + t*direction."""
        return tuple(Polynomial((o, d)) for o, d in zip(origin, direction))

    @property
    def degree(self) -> int:
        return len(self.c) - 1

    def __call__(self, t):
        """Horner's scheme."""
        value = self.c[-1]
        for coefficient in self.c[-2::-1]:
            value = value * t + coefficient
        return value

    def __neg__(self):
        return Polynomial(tuple(-a for a in self.c))

    def __add__(self, other):
        if not isinstance(other, Polynomial):
            return Polynomial((self.c[0] + other, *self.c[1:]))
        short, long = sorted((self.c, other.c), key=len)
        return Polynomial(tuple(a + b for a, b in zip(short, long)) + long[len(short):])

    __radd__ = __add__

    def __sub__(self, other):
        return self + (-other)

    def __rsub__(self, other):
        return (-self) + other

    def __mul__(self, other):
        if not isinstance(other, Polynomial):
            return Polynomial(tuple(a * other for a in self.c))
        if self.degree + other.degree > HIGHEST_DEGREE:
            raise NotAlgebraic("a polynomial of so high a degree that its coefficients are worth nothing")
        product: list = [None] * (len(self.c) + len(other.c) - 1)
        for i, a in enumerate(self.c):
            for j, b in enumerate(other.c):
                product[i + j] = a * b if product[i + j] is None else fn.fma(a, b, product[i + j])
        return Polynomial(tuple(product))

    __rmul__ = __mul__

    def __truediv__(self, other):
        if isinstance(other, Polynomial):
            raise NotAlgebraic("division by a function of the coordinates")
        return Polynomial(tuple(a / other for a in self.c))

    def __rtruediv__(self, other):
        raise NotAlgebraic("division by a function of the coordinates")

    def __pow__(self, n: int):
        if n < 0:
            raise NotAlgebraic("a negative power of the coordinates")
        if n == 0:
            return Polynomial((self.c[0] * 0 + 1,))
        half = self ** (n // 2) if n > 1 else None
        square = None if half is None else half * half
        return self if square is None else square * self if n % 2 else square

    def _not_algebraic(self, *_):
        raise NotAlgebraic("a function that is not a polynomial")

    sqrt = cbrt = sin = cos = tan = exp = log = absolute = _not_algebraic
    power = power_of = minimum = maximum = where_larger = floor = heaviside = atan2 = atan2_of = _not_algebraic


@dataclass(frozen=True, slots=True)
class OfDegree(Polynomial):
    """A polynomial whose degree is known when a kernel runs: coefficients beyond it are zero."""

    actual: object  # UInt, the degree, from 1 up to `degree`
