"""Closed form for surfaces of degree one and two: planes, spheres, ellipsoids, paraboloids, quadratic expressions."""

from __future__ import annotations

from dataclasses import dataclass

import drjit as dr

from ..numbers import OutwardInterval, Polynomial
from .interface import Intersection, LocalRay, Solid


@dataclass
class Parabola:
    """Where g(t) of a surface of degree one or two changes sign, and how it lies to the ray."""

    low: object  # Float
    high: object  # Float
    vertex: object  # Float, where |g| has its extremum
    real: object  # Bool, two distinct crossings
    discriminant: object  # Float, b^2 - a c in units of the largest coefficient squared; not finite where one is not
    far_inside: object  # Bool, g < 0 as t goes to infinity

    @staticmethod
    def along(solid: Solid, ray: LocalRay, limit) -> Parabola | None:
        """The parabola of each ray; None where the solid's polynomial is of higher degree or missing.

        Its coefficients are taken about the vertex, or the end of (0, limit) nearest to it: there they have the digits
        that c = f(o) loses far away. They are divided by the largest, so that the scale of f does not matter.
        """
        if solid.polynomial is None:
            return None
        middle = dr.clip(-dr.dot(ray.o, ray.d), 0, limit)  # nearest to the centre of the surface's frame
        coefficients = solid.polynomial(*Polynomial.along(ray.at(middle), ray.d)).c
        if len(coefficients) > 3:
            return None
        if len(coefficients) == 3:  # the vertex need not be there: a formula may hold an offset of its own
            vertex = middle - 0.5 * coefficients[1] / coefficients[2]
            middle = dr.clip(dr.select(dr.isfinite(vertex), vertex, middle), 0, limit)
            coefficients = solid.polynomial(*Polynomial.along(ray.at(middle), ray.d)).c
        largest = dr.abs(coefficients[0])
        for coefficient in coefficients[1:]:
            largest = dr.maximum(largest, dr.abs(coefficient))
        scaled = [coefficient / dr.select(largest > 0, largest, 1) for coefficient in coefficients]
        c, b = scaled[0], 0.5 * scaled[1]
        # + 0.0 turns -0.0 into +0.0: a plane is the limit of a parabola that opens upwards, its far root at infinity
        a = scaled[2] + 0.0 if len(scaled) == 3 else dr.zeros(type(c))
        discriminant = dr.fma(b, b, -a * c)
        q = -(b + dr.copysign(dr.sqrt(dr.maximum(discriminant, 0)), b))
        # q / a and c / q are the two roots without cancellation; q = 0 only for the double root 0
        first = q / a
        second = dr.select(q == 0, first, c / q)
        first = dr.select((q == 0) & (a != 0), 0, first)
        return Parabola(low=middle + dr.minimum(first, second), high=middle + dr.maximum(first, second),
                        vertex=middle - b / a, real=discriminant > 0, discriminant=discriminant,
                        far_inside=a < 0)

    def is_lost(self, solid: Solid, ray: LocalRay, inside, limit):
        """Whether rounding hides what the ray does (Bool): g at the vertex, on a ray that might only touch, is zero up to
        rounding; or the parabola contradicts the ray's side, or is no number."""
        ahead = (inside == self.far_inside) & (self.vertex > 0) & (self.vertex < limit)
        t = OutwardInterval(dr.select(ahead, self.vertex, 0))
        g = OutwardInterval.of(solid.polynomial(*(t * ray.d[k] + ray.o[k] for k in range(3))))
        contradicts = (inside != self.far_inside) & ~self.real
        return (ahead & ~g.excludes_zero()) | contradicts | ~dr.isfinite(self.discriminant)

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
    vouches = True
    closed_form = True
    variables = ()

    def first(self, solid: Solid, ray: LocalRay, inside, limit) -> Intersection:
        parabola = Parabola.along(solid, ray, limit)
        t = parabola.next_crossing(inside)
        return Intersection(t <= limit, self._polish(solid, ray, t, parabola), t,
                            parabola.is_lost(solid, ray, inside, limit), dr.full(dr.uint32_array_t(type(t)), 6))

    def crossings(self, solid: Solid, ray: LocalRay, inside, limit, only_first):
        parabola = Parabola.along(solid, ray, limit)
        first = parabola.next_crossing(inside)
        enters = inside == parabola.far_inside
        crosses = first < limit
        again = crosses & enters & (parabola.high < limit)
        UInt = dr.uint32_array_t(type(limit))
        count = dr.select(again, UInt(2), dr.select(crosses, UInt(1), 0))
        return count, parabola.is_lost(solid, ray, inside, limit)

    @staticmethod
    def _polish(solid: Solid, ray: LocalRay, t, parabola: Parabola):
        """One Newton step on f itself, which restores the last digits; refused where it is not a small correction."""
        g, slope = solid.slope_at(ray, t, solid.regular)
        dt = g / slope
        return dr.select(dr.abs(dt) < 1e-6 * dr.minimum(1, parabola.high - parabola.low), dr.maximum(t - dt, 0), t)
