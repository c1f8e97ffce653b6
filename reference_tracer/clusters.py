"""Neighbours put together: a ray that misses the ball around several objects asks none of them."""

from __future__ import annotations

import numpy as np

from .bounds import SPARE

SIZE = 8  # objects of a cluster


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
