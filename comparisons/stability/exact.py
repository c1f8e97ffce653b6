"""Exact answers: rational arithmetic for algebraic surfaces, ball arithmetic for the others (python-flint).

Floats are dyadic rationals, so a ray's numbers are taken exactly as they are. Whether a line touches or crosses is
decided, never rounded (Johansson 2017, Arb: efficient arbitrary-precision midpoint-radius interval arithmetic).
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from flint import arb, ctx, fmpq, fmpq_poly

BITS = 200  # of the enclosures that are rounded to fp64 at the end


def rational(x: float) -> fmpq:
    """The float `x`, exactly."""
    return fmpq(*float(x).as_integer_ratio())


class RationalPolynomial:
    """A polynomial in t with rational coefficients, as a number type that f can be evaluated on."""

    __slots__ = ("p",)

    def __init__(self, p: fmpq_poly):
        self.p = p

    @staticmethod
    def along(o, d) -> list[RationalPolynomial]:
        """The coordinates of o + t d."""
        return [RationalPolynomial(fmpq_poly([rational(a), rational(b)])) for a, b in zip(o, d)]

    @staticmethod
    def _of(other):
        return other.p if isinstance(other, RationalPolynomial) else rational(other)

    def __add__(self, other):
        return RationalPolynomial(self.p + self._of(other))

    def __sub__(self, other):
        return RationalPolynomial(self.p - self._of(other))

    def __mul__(self, other):
        return RationalPolynomial(self.p * self._of(other))

    def __truediv__(self, number):
        return RationalPolynomial(self.p * (1 / rational(number)))

    def __pow__(self, n: int):
        return RationalPolynomial(self.p**n)


def crossings(f: Callable, o, d, limit: float) -> list[float]:
    """All t in (0, limit] at which f changes sign along one ray, ascending: the real roots of odd multiplicity."""
    with ctx.workprec(BITS):
        numerator = f(*RationalPolynomial.along(o, d)).p.numer()
        real = [(root.real, multiplicity) for root, multiplicity in numerator.complex_roots() if root.imag == 0]
        return sorted(float(t) for t, multiplicity in real if multiplicity % 2 and 0 < t and t <= limit)


def ball_crossings(o, d, center_x, r_squared) -> np.ndarray:
    """Where the lines o + t d cross the sphere about (center_x, 0, 0), ascending; (n, 2), infinity where they do not.

    The roots of a t^2 + 2 b t + c, with a, b, c and the discriminant in rational arithmetic. `center_x` holds one
    float a line; `r_squared` one rational number a line.
    """
    roots = np.full((len(o), 2), np.inf)
    with ctx.workprec(BITS):
        for i in range(len(o)):
            x = [rational(v) for v in o[i]]
            x[0] -= rational(center_x[i])
            v = [rational(w) for w in d[i]]
            a = v[0] * v[0] + v[1] * v[1] + v[2] * v[2]
            b = x[0] * v[0] + x[1] * v[1] + x[2] * v[2]
            c = x[0] * x[0] + x[1] * x[1] + x[2] * x[2] - r_squared[i]
            discriminant = b * b - a * c
            if discriminant > 0:
                half = arb(discriminant).sqrt()
                roots[i] = float((-arb(b) - half) / arb(a)), float((-arb(b) + half) / arb(a))
    return roots


def root_between(f: Callable, low: float, high: float) -> float:
    """The root of f in [low, high], to fp64, by bisection on signs that ball arithmetic proves.

    Raises ValueError where the ends do not have proven, opposite signs.
    """
    with ctx.workprec(4 * BITS):
        a, b = rational(low), rational(high)
        start = _sign(f, a)
        if not start * _sign(f, b) < 0:
            raise ValueError(f"no proven change of sign between {low} and {high}")
        while b - a > rational(2.0**-70) * max(abs(a), abs(b), rational(1e-12)):
            middle = (a + b) / 2
            sign = _sign(f, middle)
            if sign == 0:
                return float(arb(middle))
            a, b = (middle, b) if sign == start else (a, middle)
        return float(arb((a + b) / 2))


def _sign(f: Callable, x: fmpq) -> int:
    """The proven sign of f(x); 0 only where f(x) is exactly zero."""
    value = f(arb(x))
    if value > 0:
        return 1
    if value < 0:
        return -1
    if value == 0:
        return 0
    raise ValueError(f"the sign of f at {float(arb(x))!r} cannot be proven")
