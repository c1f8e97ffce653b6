"""What every first-hit method receives and returns.

A method answers two questions about one solid and many rays: where does the ray first change side, and how often does
it change side on a segment. It is told the side each ray starts on (decision M2). A hit is a change of sign (M1).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import drjit as dr

from ..numbers import Dual, Interval, OutwardInterval


@dataclass
class LocalRay:
    """Rays in the frame of one solid: origin and unit direction."""

    o: object
    d: object

    def at(self, t):
        return dr.fma(self.d, t, self.o)


class Solid:
    """One object of every lane, as the methods see it: f in its own frame, and the box that bounds it.

    `f`, `regular` and `polynomial` (None where there is none) are functions of three coordinates of any number type;
    `far_inside` tells on which side the ray is outside of the box.
    """

    def __init__(self, f, regular, polynomial, box, far_inside):
        self.f, self.regular, self.polynomial, self.box, self.far_inside = f, regular, polynomial, box, far_inside

    def inside_at(self, ray: LocalRay, t):
        """Whether the point at t is inside: f < 0, so that zero and anything not finite is outside (O1, M7)."""
        g = self.f(*ray.at(t))
        return (g < 0) & (g > -dr.inf)

    def slope_at(self, ray: LocalRay, t, form=None):
        """g(t) = f(o + t d) and g'(t), by dual numbers (section 4.2)."""
        g = (form or self.f)(*Dual.along(ray.at(t), ray.d))
        return g.value, g.derivative()

    def enclose(self, ray: LocalRay, t0, t1, number: type[Interval]):
        """Intervals that hold g and g' on all of [t0, t1]."""
        span = number(t0, t1)
        point = tuple(span * ray.d[k] + ray.o[k] for k in range(3))
        g = self.regular(*Dual.along(point, tuple(number(ray.d[k]) for k in range(3))))
        return number.of(g.value), number.of(g.derivative())

    def value(self, ray: LocalRay, t) -> OutwardInterval:
        """An enclosure of g(t) of the regular form at one point, every rounding counted."""
        t = OutwardInterval(t)
        return OutwardInterval.of(self.regular(*(t * ray.d[k] + ray.o[k] for k in range(3))))

    def span(self, ray: LocalRay, limit):
        """The part [t0, t1] of (0, limit) in which the ray may meet the solid; t0 > t1 where it cannot.

        The ray's meeting with the solid's box by the slab method (Kay and Kajiya 1986).
        """
        t0, t1 = dr.zeros(type(limit)), limit
        if self.box is not None:
            low, high = self.box
            for k in range(3):
                per_d = 1 / dr.select(dr.abs(ray.d[k]) < 1e-30, 1e-30, ray.d[k])  # parallel to the slab
                near, far = (low[k] - ray.o[k]) * per_d, (high[k] - ray.o[k]) * per_d
                t0 = dr.maximum(t0, dr.minimum(near, far))
                t1 = dr.minimum(t1, dr.maximum(near, far))
        return t0, t1

    def search_range(self, ray: LocalRay, inside, limit):
        """The part of (0, limit) to search: the box, unless the ray starts within the solid and has to come out."""
        start, stop = self.span(ray, limit)
        if self.box is None:
            return start, stop
        outside = inside == self.far_inside
        return dr.select(outside, start, 0), dr.select(outside, stop, limit)


@dataclass
class Intersection:
    """Where each ray first changes side."""

    found: object  # Bool
    t: object  # Float
    order: object  # Float, see rays.Hit
    undecided: object  # Bool
    evaluations: object  # UInt, how often f was evaluated: the cost that does not depend on the machine


class FirstHit(Protocol):
    """A method that finds where rays change side."""

    name: str
    vouches: bool  # its distances are those of first crossings, but for rounding
    closed_form: bool  # cheap enough not to ask first whether the ray meets the solid's bounds
    variables: tuple = ()  # the arrays that its kernels read

    def first(self, solid: Solid, ray: LocalRay, inside, limit) -> Intersection:
        """The first change of side of each ray on (0, limit]; `inside` is the side it starts on."""

    def crossings(self, solid: Solid, ray: LocalRay, inside, limit, only_first):
        """How often each ray changes side on (0, limit), as (UInt, Bool undecided).

        Where `only_first` holds, one crossing says it all and the count may stop at 1.
        """
