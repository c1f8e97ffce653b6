"""Closed form for bounded surfaces of degree two: spheres, ellipsoids, however written."""

from __future__ import annotations

from dataclasses import dataclass

import drjit as dr

from ..numbers import OutwardInterval, Polynomial
from .interface import Intersection, LocalRay, Solid

# (half chord / extent)^2 below which rounding might decide whether a ray cuts; the others are spared the question. At the
# vertex it is wrong by few times 2^-52 (distance / extent) at most, and distances beyond 2^36 extents leave no digits.
DOUBTFUL = 2.0**-12


@dataclass
class Chord:
    """The part of a ray's line within a bounded quadric."""

    middle: object  # Float
    half_squared: object  # Float, square of half its length; negative where the line passes by

    @staticmethod
    def along(solid: Solid, ray: LocalRay, limit) -> Chord:
        """The chord of each ray.

        g(t) = a t^2 + 2 b t + c has its extremum at -b / a; there g is evaluated anew, with the digits that
        b^2 - a c loses far away. Whatever the scale of f, only quotients by a enter.
        """
        nearest = dr.clip(-dr.dot(ray.o, ray.d), 0, limit)  # to the centre of the surface's frame
        _, twice_b, a = solid.polynomial(*Polynomial.along(ray.at(nearest), ray.d)).c
        per_a = 1 / a
        vertex = nearest - 0.5 * twice_b * per_a
        g, slope = solid.slope_at(ray, vertex, solid.polynomial)
        rest = 0.5 * slope * per_a  # what rounding left of b at the vertex
        return Chord(vertex - rest, rest * rest - g * per_a)

    @property
    def ends(self):
        half = dr.sqrt(dr.maximum(self.half_squared, 0))
        return self.middle - half, self.middle + half

    def next_crossing(self, outside):
        """The t at which each ray changes side; infinity where it never does (Float).

        Knowing the side replaces every epsilon: a ray that leaves the surface starts at an end of the chord, whose
        computed value is noise around zero. From outside it can only enter, and only if the middle lies ahead; from
        inside it leaves at the far end.
        """
        enters = (self.half_squared > 0) & (self.middle > 0)
        low, high = self.ends
        return dr.maximum(dr.select(outside, dr.select(enters, low, dr.inf), high), 0)

    def is_lost(self, solid: Solid, ray: LocalRay, outside, limit):
        """Whether rounding hides what the ray does (Bool): it passes by, or barely cuts, and touches the surface up to
        rounding; or its chord contradicts its side, or is no number."""
        ahead = outside & (self.middle > 0) & (self.middle < limit)
        low, high = solid.box
        close = ahead & (dr.abs(self.half_squared) < DOUBTFUL * dr.squared_norm(high - low))
        lost = ~dr.isfinite(self.half_squared) | ~(outside | (self.half_squared > 0))  # M7; or within, but never meets it
        return lost | dr.if_stmt((), close, lambda: self._is_zero(solid, ray), lambda: dr.mask_t(limit)(False))

    def _is_zero(self, solid: Solid, ray: LocalRay):
        t = OutwardInterval(self.middle)
        return ~OutwardInterval.of(solid.polynomial(*(t * ray.d[k] + ray.o[k] for k in range(3)))).excludes_zero()


class BoundedQuadric:
    """First hits and crossings from the chord; what the ray's side says decides which end counts."""

    name = "bounded quadric"
    vouches = True
    closed_form = True
    variables = ()

    def first(self, solid: Solid, ray: LocalRay, inside, limit) -> Intersection:
        outside = inside == solid.far_inside
        chord = Chord.along(solid, ray, limit)
        t = chord.next_crossing(outside)
        return Intersection(t <= limit, t, t, chord.is_lost(solid, ray, outside, limit),
                            dr.full(dr.uint32_array_t(type(t)), 5))

    def crossings(self, solid: Solid, ray: LocalRay, inside, limit, only_first):
        outside = inside == solid.far_inside
        chord = Chord.along(solid, ray, limit)
        first = chord.next_crossing(outside)
        UInt = dr.uint32_array_t(type(limit))
        again = outside & (chord.ends[1] < limit)
        count = dr.select(first < limit, dr.select(again, UInt(2), UInt(1)), UInt(0))
        return count, chord.is_lost(solid, ray, outside, limit)
