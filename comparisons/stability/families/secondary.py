"""Rays that start on the surface: on which side are they?"""

from __future__ import annotations

import math

import numpy as np

from ..exact import ball_crossings, rational
from ..family import About, SurfaceFamily
from ..law import Law
from ..methods import SIDE_FROM_SIGN, offset
from ..rays import Draw, Rays, unit
from .balls import BALL, STEP

EPSILONS = (1e-2, 1e-4, 1e-6)


def _from_the_surface(angle: float, draw: Draw) -> Rays:
    """Origins that miss the unit sphere by noise; every other ray goes in and crosses the ball, the rest leave.

    The noise stays a hundredth of what would lift a ray that goes in off the ball altogether, sin^2(angle) / 2.
    """
    normal = draw.directions()
    tangent = unit(np.cross(normal, draw.directions()))
    inwards = np.arange(draw.count) % 2 == 1
    noise = min(1e-12, 5e-3 * math.sin(angle) ** 2) if not draw.single else 1e-7
    o = draw.stored(normal * (1 + noise * draw.uniform(-1, 1)[:, None]))
    rise = np.where(inwards, -1.0, 1.0)[:, None] * math.sin(angle)
    d = draw.stored(unit(math.cos(angle) * tangent + rise * normal))
    roots = ball_crossings(o, d, np.zeros(len(o)), [rational(1.0)] * len(o))
    # going out: both crossings are the noise at the origin, or behind it
    first = np.where(inwards, roots[:, 1], np.inf)
    accuracy = max((1e-2 if draw.single else 1e-3) * 2 * math.sin(angle), 1e-12)
    return Rays.of(o, d, inside=inwards, limit=3.0, first=first, others=roots[:, :1], accuracy=accuracy, step=STEP,
                   center_x=0.0, r=1.0, scale=1.0)


def _offset_law(epsilon: float) -> Law:
    rate = lambda p: 0.5 if epsilon > 2 * math.sin(p) else 0.0
    return Law(offset(epsilon).name, f"1/2 where the chord 2 sin(p) is shorter than {epsilon:g}, else 0", rate)


FAMILIES = (
    SurfaceFamily(
        About("secondary-rays", "Secondary rays at grazing angles", "angle between the ray and the surface, radians",
              (0.5, 0.1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6),
              when="A ray starts on a surface and the side it is on is guessed.",
              why="f at its origin is rounding noise, so half of the guesses are wrong; an offset along the ray is "
                  "wrong as soon as the ray leaves the solid again within it.",
              instead="Inherit the side from the parent ray (decision M3): no epsilon, no failure at any angle.",
              single=(0.5, 0.1, 1e-2)),
        BALL, _from_the_surface, variants=(SIDE_FROM_SIGN, *map(offset, EPSILONS)),
        laws=(Law("paper", "0: the side is inherited", lambda p: 0.0),
              Law(SIDE_FROM_SIGN.name, "1/2: the sign of noise", lambda p: 0.5), *map(_offset_law, EPSILONS))),)
