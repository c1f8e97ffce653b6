"""A family of quadratic polynomials that are almost linear along the ray."""

from __future__ import annotations

import math

import numpy as np

from ..exact import crossings, rational
from ..family import About, Shape, SurfaceFamily
from ..rays import Draw, Rays, unit

LIMIT = 30.0
CONE = Shape(lambda x, y, z: x**2 + y**2 - z**2, degree=2)


def _along_generator(angle: float, draw: Draw) -> Rays:
    """Rays at `angle` to a generator of the double cone, from points around its tip.

    Where they are parallel, t^2 has the coefficient zero, or what rounding makes of it: the second root is at infinity.
    """
    turn = draw.uniform(0, 2 * math.pi)
    generator = np.column_stack([np.cos(turn), np.sin(turn), np.ones(draw.count)]) / math.sqrt(2)
    aside = unit(np.cross(generator, draw.directions()))
    o = draw.stored(draw.uniform(-2, 2, (3,)))
    d = draw.stored(unit(math.cos(angle) * generator + math.sin(angle) * aside))
    roots = [crossings(CONE.f, a, b, math.inf) for a, b in zip(o, d)]
    table = np.array([t + [np.inf] * (2 - len(t)) for t in roots])
    x, y, z = ([rational(v) for v in column] for column in o.T)
    inside = [a * a + b * b < c * c for a, b, c in zip(x, y, z)]
    first = np.where(table[:, 0] <= LIMIT, table[:, 0], np.inf)
    return Rays.of(o, d, inside=inside, first=first, others=table[:, 1:], limit=LIMIT,
                   accuracy=(1e-3 if draw.single else 1e-6) * LIMIT)


FAMILIES = (
    SurfaceFamily(
        About("asymptote", "Along a generator of a cone", "angle between ray and generator, radians",
              (1e-1, 1e-3, 1e-6, 1e-9, 1e-12, 1e-15, 0.0),
              when="A ray is almost parallel to a straight line of a quadric.",
              why="The coefficient of t^2 is rounding noise: dividing by it, or trusting its sign, makes up a root.",
              instead="The formula without cancellation, and the side the ray is on to choose the root.",
              single=(1e-1, 1e-3, 1e-6, 0.0)),
        CONE, _along_generator),)
