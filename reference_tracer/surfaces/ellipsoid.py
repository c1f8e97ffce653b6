from __future__ import annotations

from typing import ClassVar, Literal

from .surface import Length, Surface


class Ellipsoid(Surface):
    """An ellipsoid with semi-axes a, b, c along x, y, z (section 7.1.3)."""

    type: Literal["ellipsoid"] = "ellipsoid"
    a: Length
    b: Length
    c: Length

    title: ClassVar[str] = "Ellipsoid"
    equation: ClassVar[str] = "(x − x₀)²/a² + (y − y₀)²/b² + (z − z₀)²/c² − 1 = 0"
    polynomial_degree: ClassVar[int] = 2

    @staticmethod
    def f(x, y, z, a, b, c):
        return x**2 / a**2 + y**2 / b**2 + z**2 / c**2 - 1

    def box(self):
        return (-self.a, -self.b, -self.c), (self.a, self.b, self.c)
