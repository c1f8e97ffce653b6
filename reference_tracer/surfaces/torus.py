from __future__ import annotations

from typing import ClassVar, Literal

from ..numbers.functions import sqrt
from .surface import Length, Surface


class Torus(Surface):
    """A torus about the z axis: a tube of radius r along a circle of radius R (section 7.1.4, decision O4).

    For r > R the tube overlaps itself; the square-root form then has no inner sheet. The gradient does not exist on
    the axis x = y = 0.
    """

    type: Literal["torus"] = "torus"
    R: Length
    r: Length

    title: ClassVar[str] = "Torus"
    equation: ClassVar[str] = "(√((x − x₀)² + (y − y₀)²) − R)² + (z − z₀)² − r² = 0"

    @staticmethod
    def f(x, y, z, R, r):
        return (sqrt(x**2 + y**2) - R) ** 2 + z**2 - r**2

    def box(self):
        outer, r = self.R + self.r, self.r
        return (-outer, -outer, -r), (outer, outer, r)
