"""Closed form for surfaces of degree one: planes, linear expressions."""

from __future__ import annotations

import drjit as dr

from .interface import Intersection, LocalRay, Solid


class Linear:
    """g(t) = f(o) + t g' has one root, and the side a ray is known to be on says whether it lies ahead.

    A ray that leaves the plane starts on it, and f(o) is noise around zero: where g runs away from the other side
    there is no crossing, whatever the sign of f(o).
    """

    name = "linear"
    vouches = True
    closed_form = True
    variables = ()

    def first(self, solid: Solid, ray: LocalRay, inside, limit) -> Intersection:
        g, slope = solid.slope_at(ray, dr.zeros(type(ray.o[0])), solid.regular)
        leaves = dr.select(inside, slope > 0, slope < 0)
        t = dr.select(leaves, dr.maximum(-g / slope, 0), dr.inf)
        return Intersection(t <= limit, t, t, ~dr.isfinite(g + slope), dr.full(dr.uint32_array_t(type(t)), 1))

    def crossings(self, solid: Solid, ray: LocalRay, inside, limit, only_first):
        # one sign change at most: the sides of the two ends tell
        g = solid.regular(*ray.at(limit))
        crosses = ((g < 0) != inside) & (limit > 0)
        return dr.select(crosses, dr.uint32_array_t(type(limit))(1), 0), ~dr.isfinite(g)
