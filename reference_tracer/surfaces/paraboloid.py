from __future__ import annotations

from typing import ClassVar, Literal

from .surface import Length, Surface


class Paraboloid(Surface):
    """An elliptic paraboloid that opens along +z (section 7.1.5, decision O2). Unbounded."""

    type: Literal["paraboloid"] = "paraboloid"
    a: Length
    b: Length

    title: ClassVar[str] = "Elliptic paraboloid"
    equation: ClassVar[str] = "z − z₀ = (x − x₀)²/a² + (y − y₀)²/b²"
    polynomial_degree: ClassVar[int] = 2

    @staticmethod
    def f(x, y, z, a, b):
        return x**2 / a**2 + y**2 / b**2 - z
