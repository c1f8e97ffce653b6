"""Balls around bounded solids, and around neighbours: the cheapest question whether a ray can meet one at all."""

from __future__ import annotations

from dataclasses import dataclass

import drjit as dr
import numpy as np

SIZE = 8  # objects of a cluster: a ray that misses the ball around it asks none of them
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


def spatial_order(centers: np.ndarray) -> np.ndarray:
    """A permutation of the points (n, 3) in which every SIZE consecutive ones, counted from the first, are near.

    Halves the points at the middle of their longest extent, as a k-d tree is built (Bentley 1975).
    """
    def halved(rows: np.ndarray) -> np.ndarray:
        if len(rows) <= SIZE:
            return rows
        points = centers[rows]
        rows = rows[np.argsort(points[:, np.ptp(points, axis=0).argmax()], kind="stable")]
        half = SIZE * ((len(rows) // SIZE + 1) // 2)
        return np.concatenate([halved(rows[:half]), halved(rows[half:])])

    return halved(np.arange(len(centers)))


def cluster_balls(centers: np.ndarray, radii: np.ndarray) -> np.ndarray:
    """Balls (k, 4), centre and radius, around every SIZE consecutive balls."""
    balls = []
    for start in range(0, len(centers), SIZE):
        c, r = centers[start:start + SIZE], radii[start:start + SIZE]
        middle = 0.5 * ((c - r[:, None]).min(axis=0) + (c + r[:, None]).max(axis=0))
        balls.append([*middle, SPARE * float((np.linalg.norm(c - middle, axis=1) + r).max())])
    return np.array(balls)
