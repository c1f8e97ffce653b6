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

    @staticmethod
    def f_polynomial(x, y, z, R, r):
        # f times (√(x² + y²) + R)² + z² − r², which is positive everywhere as long as r < R
        square = x**2 + y**2
        return (square + z**2 + (R**2 - r**2)) ** 2 - square * (R**2 * 4)

    @property
    def family(self):
        return self.type if self.r < self.R else f"{self.type} that overlaps itself"

    @property
    def degree(self):
        return 4 if self.r < self.R else None

    @property
    def polynomial_form(self):
        return type(self).f_polynomial if self.r < self.R else None

    def box(self):
        outer, r = self.R + self.r, self.r
        return (-outer, -outer, -r), (outer, outer, r)
