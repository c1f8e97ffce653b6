from __future__ import annotations

from typing import ClassVar, Literal

from ..numbers.functions import cbrt
from .surface import Surface


class Heart(Surface):
    """The heart of section 7.1.6, upright along y, about 2.3 wide; its constant is 9/80 exactly (decision O5).

    With A = x² + 9/4 z² + y² − 1 and B = x² + 9/80 z² the printed form is A³ − y³ B. Its gradient vanishes on the whole
    ellipse y = 0, A = 0, a triple root, so neither Newton nor the normal can be taken from it there. A − y ∛B has
    the same zeros and signs, because a³ − b³ and a − b do, and a gradient everywhere but at the two tips (0, ±1, 0).
    """

    type: Literal["heart"] = "heart"

    title: ClassVar[str] = "Heart"
    equation: ClassVar[str] = "(x² + 9/4 z² + y² − 1)³ − x²y³ − 9/80 z²y³ = 0"
    polynomial_degree: ClassVar[int] = 6

    @staticmethod
    def f(x, y, z):
        return (x**2 + z**2 * 2.25 + y**2 - 1) ** 3 - x**2 * y**3 - z**2 * y**3 * 9 / 80

    @staticmethod
    def f_regular(x, y, z):
        return x**2 + z**2 * 2.25 + y**2 - 1 - y * cbrt(x**2 + z**2 * 9 / 80)

    @property
    def regular_form(self):
        return type(self).f_regular

    def box(self):
        # measured extents 1.1390, [-1, 1.2363], 0.7141 (test_surfaces proves f > 0 on the faces of this box)
        return (-1.15, -1.01, -0.73), (1.15, 1.25, 0.73)
