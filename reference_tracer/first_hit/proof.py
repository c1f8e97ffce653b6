"""Interval arithmetic, outward rounded: what this method says of a ray is a proof."""

from __future__ import annotations

import drjit as dr

from ..numbers import Interval, OutwardInterval
from .interface import LocalRay, Solid
from .interval import IntervalMethod

WIDEST = 40  # doublings of a unit in the last place that an enclosure may grow by


class Proof(IntervalMethod):
    """The algorithm of `IntervalMethod` with every rounding counted and every sign certain.

    Proven is: for the ray o + t d in the solid's frame, its numbers taken exactly as the floats they are, and given the
    side it starts on, the first change of side lies in the bracket found, or there is none. Signs at the ends of
    segments come from thin intervals; where such a sign is uncertain the segment is divided, and at last undecided.
    """

    name = "proof"
    number = OutwardInterval

    def _end_of_segment(self, solid: Solid, ray: LocalRay, end):
        g = self._value(solid, ray, end)
        return 0.5 * (g.low + g.high), g.high < 0, g.low > 0

    def _bounded_away(self, g_start, g_end, slope: Interval, w, side):
        return False  # its products are rounded to nearest: not a proof

    @staticmethod
    def _value(solid: Solid, ray: LocalRay, t) -> Interval:
        """An enclosure of g(t) at one point."""
        t = OutwardInterval(t)
        return OutwardInterval.of(solid.regular(*(t * ray.d[k] + ray.o[k] for k in range(3))))

    @dr.syntax
    def radius(self, solid: Solid, ray: LocalRay, t, active):
        """The least r tried, from one unit in the last place up, such that g changes side between t - r and t + r.

        A proof that a crossing lies within r of t; infinity where none of the tried r shows it.
        """
        Float = type(t)
        r = dr.maximum(dr.abs(t), 1e-3) * 2.0**-52
        proven = Float(dr.inf)
        tries = dr.zeros(dr.uint32_array_t(Float))
        searching = dr.mask_t(t)(active)
        while searching:
            before, after = self._value(solid, ray, t - r), self._value(solid, ray, t + r)
            changes = ((before.high < 0) & (after.low > 0)) | ((before.low > 0) & (after.high < 0))
            proven = dr.select(changes, r, proven)
            tries += 1
            searching = ~changes & (tries < WIDEST)
            r = 2 * r
        return proven
