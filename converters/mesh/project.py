"""Newton's method that carries vertices onto f = 0 in fp64."""

from __future__ import annotations

import numpy as np

from .placed import Placed

MOST_STEPS = 12
ROUNDING = 1e-15  # relative: a step shorter than this cannot improve a coordinate any more


def project(placed: Placed, points: np.ndarray, cell: np.ndarray) -> np.ndarray:
    """`points` (n, 3) carried along the gradient onto f = 0: x <- x - f grad f / |grad f|^2.

    A step is at most one `cell` (3,) long along each axis. A point whose residual did not fall, or that moved by more
    than two cells, stays where it was: Newton may wander near points without a gradient.
    """
    moved = points.copy()
    start = None
    moving = np.arange(len(points))
    for _ in range(MOST_STEPS):
        values, gradients = placed.gradient(moved[moving])
        if start is None:
            start = np.abs(values)
        with np.errstate(all="ignore"):
            step = gradients * (-values / np.einsum("ij,ij->i", gradients, gradients))[:, None]
            length = np.linalg.norm(step, axis=1)
            step *= np.minimum(1, (cell / np.abs(step)).min(axis=1))[:, None]
        step[~np.isfinite(step).all(axis=1)] = 0
        moved[moving] += step
        moving = moving[length > ROUNDING * (1 + np.abs(moved[moving]).max(axis=1, initial=0))]
        if not len(moving):
            break
    with np.errstate(all="ignore"):
        improved = ~(np.abs(placed.values(*moved.T)) > start) & (np.abs(moved - points) <= 2 * cell).all(axis=1)
    return np.where(improved[:, None], moved, points)


def normals_at(placed: Placed, vertices: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Unit normals (n, 3) from the gradient; where it does not exist, the mean of the faces around, by area."""
    _, gradients = placed.gradient(vertices)
    with np.errstate(all="ignore"):
        normals = gradients / np.linalg.norm(gradients, axis=1, keepdims=True)
    missing = ~np.isfinite(normals).all(axis=1)
    if missing.any():
        a, b, c = vertices[faces.T]
        sums = np.zeros_like(vertices)
        for corner in faces.T:
            np.add.at(sums, corner, np.cross(b - a, c - a))
        normals[missing] = sums[missing] / np.linalg.norm(sums[missing], axis=1, keepdims=True)
    return normals
