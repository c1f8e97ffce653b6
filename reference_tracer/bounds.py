"""Balls around bounded solids: the cheapest question whether a ray can meet one at all."""

from __future__ import annotations

from dataclasses import dataclass

import drjit as dr
import numpy as np

SPARE = 1 + 1e-6  # of the radius: covers the rounding of the test for origins up to 1e9 radii away


def bounding_ball(low: np.ndarray, high: np.ndarray) -> float:
    """The radius of the least ball about the origin that holds the box from `low` to `high`."""
    return float(np.linalg.norm(np.maximum(np.abs(low), np.abs(high)))) * SPARE


@dataclass
class Ball:
    """A ball in world space; one about a solid's own centre needs no rotation."""

    center: object  # Vector
    radius: object  # Float

    def may_meet(self, o, d, limit):
        """Whether the segment o + t d, 0 < t < limit, may enter the ball (Bool); sure where it says no."""
        to_center = self.center - o
        t = dr.dot(to_center, d)  # of the point nearest to the centre
        away = dr.fma(d, -t, to_center)
        return (dr.squared_norm(away) <= self.radius * self.radius) & (t > -self.radius) & (t - self.radius < limit)
