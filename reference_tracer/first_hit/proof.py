"""Interval arithmetic, outward rounded: what this method says of a ray is a proof."""

from __future__ import annotations

import drjit as dr

from ..numbers import OutwardInterval
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
        g = solid.value(ray, end)
        inside, outside = g.high < 0, g.low > 0
        return dr.select(inside, g.high, dr.select(outside, g.low, 0)), inside, outside

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
            before, after = solid.value(ray, t - r), solid.value(ray, t + r)
            changes = ((before.high < 0) & (after.low > 0)) | ((before.low > 0) & (after.high < 0))
            proven = dr.select(changes, r, proven)
            tries += 1
            searching = ~changes & (tries < WIDEST)
            r = 2 * r
        return proven
