"""Closed form for surfaces of degree one and two: planes, spheres, ellipsoids, paraboloids, quadratic expressions."""

from __future__ import annotations

from dataclasses import dataclass

import drjit as dr

from ..numbers import Polynomial
from .interface import Crossing, LocalRay, Solid


@dataclass
class _Roots:
    """Where the parabola g(t) changes sign, and how it lies to the ray."""

    low: object  # Float
    high: object  # Float
    vertex: object  # Float, where |g| has its extremum
    real: object  # Bool, two distinct crossings
    far_inside: object  # Bool, g < 0 as t goes to infinity


class Quadratic:
    """Solves g(t) = a t^2 + 2 b t + c = 0 and lets the side a ray is known to be on decide which root counts.

    Knowing the side replaces every epsilon: a ray that leaves a surface starts at a root, whose computed value is
    noise around zero. If the ray is outside of the parabola's lobe, it can only enter at the lower root, and only if
    the vertex lies ahead; if it is within the lobe, it leaves at the upper root.
    """

    name = "quadratic"

    def first(self, solid: Solid, ray: LocalRay, inside, limit) -> Crossing:
        roots = self._roots(solid, ray)
        outer = inside == roots.far_inside
        t = dr.maximum(dr.select(outer, roots.low, roots.high), 0)
        found = dr.select(outer, roots.real & (roots.vertex > 0), True) & (t <= limit)
        return Crossing(found, self._polish(solid, ray, t, roots), t, dr.zeros(type(found)),
                        dr.full(dr.uint32_array_t(type(t)), 5))

    def crossings(self, solid: Solid, ray: LocalRay, inside, limit, only_first):
        roots = self._roots(solid, ray)
        outer = inside == roots.far_inside
        enters = outer & roots.real & (roots.vertex > 0) & (roots.low < limit)
        leaves = (enters | ~outer) & (roots.high < limit)
        counter = dr.uint32_array_t(type(limit))
        return dr.select(enters, counter(1), 0) + dr.select(leaves, counter(1), 0), dr.zeros(type(enters))

    @staticmethod
    def _roots(solid: Solid, ray: LocalRay) -> _Roots:
        # Expanding about the point nearest to the surface's centre keeps the digits that c = f(o) loses far away.
        nearest = -dr.dot(ray.o, ray.d)
        coefficients = solid.polynomial(*Polynomial.along(ray.at(nearest), ray.d)).c
        c, b = coefficients[0], 0.5 * coefficients[1]
        # + 0.0 turns -0.0 into +0.0: a plane is the limit of a parabola that opens upwards, its far root at infinity
        a = coefficients[2] + 0.0 if len(coefficients) > 2 else dr.zeros(type(c))
        discriminant = dr.fma(b, b, -a * c)
        q = -(b + dr.copysign(dr.sqrt(dr.maximum(discriminant, 0)), b))
        # q / a and c / q are the two roots without cancellation; q = 0 only for the double root 0
        first = q / a
        second = dr.select(q == 0, first, c / q)
        first = dr.select((q == 0) & (a != 0), 0, first)
        return _Roots(low=nearest + dr.minimum(first, second), high=nearest + dr.maximum(first, second),
                      vertex=nearest - b / a, real=discriminant > 0, far_inside=a < 0)

    @staticmethod
    def _polish(solid: Solid, ray: LocalRay, t, roots: _Roots):
        """One Newton step on f itself, which restores the last digits; refused where it is not a small correction."""
        g, slope = solid.slope_at(ray, t)
        dt = g / slope
        return dr.select(dr.abs(dt) < 1e-6 * dr.minimum(1, roots.high - roots.low), dr.maximum(t - dt, 0), t)
