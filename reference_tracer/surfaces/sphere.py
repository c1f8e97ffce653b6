from __future__ import annotations

from typing import ClassVar, Literal

from .surface import Length, Surface


class Sphere(Surface):
    """A ball of radius r (section 7.1.2)."""

    type: Literal["sphere"] = "sphere"
    r: Length

    title: ClassVar[str] = "Sphere"
    equation: ClassVar[str] = "(x − x₀)² + (y − y₀)² + (z − z₀)² − r² = 0"
    polynomial_degree: ClassVar[int] = 2

    @staticmethod
    def f(x, y, z, r):
        return x**2 + y**2 + z**2 - r**2

    def box(self):
        r = self.r
        return (-r, -r, -r), (r, r, r)
