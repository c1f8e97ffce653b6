"""Closed form for surfaces of degree one and two: planes, spheres, ellipsoids, paraboloids, quadratic expressions."""

from __future__ import annotations

from dataclasses import dataclass

import drjit as dr

from ..numbers import Polynomial
from .interface import Crossing, LocalRay, Solid


@dataclass
class Parabola:
    """Where g(t) of a surface of degree one or two changes sign, and how it lies to the ray."""

    low: object  # Float
    high: object  # Float
    vertex: object  # Float, where |g| has its extremum
    real: object  # Bool, two distinct crossings
    far_inside: object  # Bool, g < 0 as t goes to infinity

    @staticmethod
    def along(solid: Solid, ray: LocalRay) -> Parabola | None:
        """The parabola of each ray; None where the solid's polynomial is of higher degree or missing."""
        if solid.polynomial is None:
            return None
        # Expanding about the point nearest to the surface's centre keeps the digits that c = f(o) loses far away.
        nearest = -dr.dot(ray.o, ray.d)
        coefficients = solid.polynomial(*Polynomial.along(ray.at(nearest), ray.d)).c
        if len(coefficients) > 3:
            return None
        c, b = coefficients[0], 0.5 * coefficients[1]
        # + 0.0 turns -0.0 into +0.0: a plane is the limit of a parabola that opens upwards, its far root at infinity
        a = coefficients[2] + 0.0 if len(coefficients) > 2 else dr.zeros(type(c))
        discriminant = dr.fma(b, b, -a * c)
        q = -(b + dr.copysign(dr.sqrt(dr.maximum(discriminant, 0)), b))
        # q / a and c / q are the two roots without cancellation; q = 0 only for the double root 0
        first = q / a
        second = dr.select(q == 0, first, c / q)
        first = dr.select((q == 0) & (a != 0), 0, first)
        return Parabola(low=nearest + dr.minimum(first, second), high=nearest + dr.maximum(first, second),
                        vertex=nearest - b / a, real=discriminant > 0, far_inside=a < 0)

    def next_crossing(self, inside):
        """The t of the first change of side of a ray on side `inside`; infinity where there is none (Float)."""
        outer = inside == self.far_inside
        enters = self.real & (self.vertex > 0)
        t = dr.select(outer, dr.select(enters, self.low, dr.inf), self.high)
        return dr.maximum(t, 0)


class Quadratic:
    """Solves g(t) = a t^2 + 2 b t + c = 0 and lets the side a ray is known to be on decide which root counts.

    Knowing the side replaces every epsilon: a ray that leaves a surface starts at a root, whose computed value is
    noise around zero. If the ray is outside of the parabola's lobe, it can only enter at the lower root, and only if
    the vertex lies ahead; if it is within the lobe, it leaves at the upper root.
    """

    name = "quadratic"

    def first(self, solid: Solid, ray: LocalRay, inside, limit) -> Crossing:
        parabola = Parabola.along(solid, ray)
        t = parabola.next_crossing(inside)
        found = t <= limit
        return Crossing(found, self._polish(solid, ray, t, parabola), t, dr.zeros(type(found)),
                        dr.full(dr.uint32_array_t(type(t)), 5))

    def crossings(self, solid: Solid, ray: LocalRay, inside, limit, only_first):
        parabola = Parabola.along(solid, ray)
        first = parabola.next_crossing(inside)
        enters = inside == parabola.far_inside
        crosses = first < limit
        again = crosses & enters & (parabola.high < limit)
        UInt = dr.uint32_array_t(type(limit))
        return dr.select(again, UInt(2), dr.select(crosses, UInt(1), 0)), dr.zeros(type(crosses))

    @staticmethod
    def _polish(solid: Solid, ray: LocalRay, t, parabola: Parabola):
        """One Newton step on f itself, which restores the last digits; refused where it is not a small correction."""
        g, slope = solid.slope_at(ray, t)
        dt = g / slope
        return dr.select(dr.abs(dt) < 1e-6 * dr.minimum(1, parabola.high - parabola.low), dr.maximum(t - dt, 0), t)
