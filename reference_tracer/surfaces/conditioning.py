"""How far the rounding of f may move its surface: what methods that compute with plain floats cannot see.

Where large terms cancel, as in (x**2 + y**2 + z**2 - 1 + 1e17) - 1e17 or a ball far away written as x**2 - 2e4*x + ...,
f at a float has the rounding of its terms, not of its value. Divided by the slope of f that is a distance (the condition
of a root: Higham, Accuracy and Stability of Numerical Algorithms, chapter 1).
"""

from __future__ import annotations

import numpy as np

from ..numbers import Dual, OutwardInterval
from .surface import Box, Surface

POINTS, STEPS = 64, 24  # random points, and steps of Newton's towards the surface from each, at most
AT_REST = 2.0**-45  # of a coordinate: no step is longer, so that the next would move the shift by no more
AROUND = ((-2.0,) * 3, (2.0,) * 3)  # where they start if no box is known
LARGEST_SHIFT = 2.0**-42  # of a coordinate: 2^10 units of rounding, below which interval methods divide no further


def shift(surface: Surface, box: Box | None) -> float:
    """The median, over points near the surface, of the distance that rounding may move it by, relative to 1 + |point|.

    NaN where no such point is found. Outward rounded intervals count the rounding of every operation.
    """
    form, parameters = surface.regular_form, surface.parameters
    low, high = (np.array(corner, float)[:, None] for corner in box or AROUND)
    points = low + (high - low) * np.random.default_rng(0).random((3, POINTS))
    with np.errstate(all="ignore"):
        for _ in range(STEPS):
            g = form(*Dual.axes(tuple(points)), **parameters)
            slopes = np.stack([np.broadcast_to(g.derivative(k), POINTS) for k in range(3)])
            size = np.abs(slopes).max(axis=0)
            step = (slopes / size) * (g.value / size) / np.square(slopes / size).sum(axis=0)
            step = np.where(np.isfinite(step), step, 0.0)
            points = points - step
            if (np.abs(step) <= AT_REST * (1 + np.abs(points))).all():
                break
        g = form(*Dual.axes(tuple(OutwardInterval(p) for p in points)), **parameters)
        value = OutwardInterval.of(g.value)
        slope = [OutwardInterval.of(g.derivative(k)) for k in range(3)]
        steepest = np.max([np.broadcast_to(np.maximum(np.abs(s.low), np.abs(s.high)), POINTS) for s in slope], axis=0)
        relative = (value.high - value.low) / steepest / (1 + np.abs(points).max(axis=0))
    relative = relative[np.isfinite(relative)]
    return float(np.median(relative)) if len(relative) else float("nan")


def drowns(surface: Surface, box: Box | None) -> bool:
    """Whether rounding hides the surface from methods that do not count it."""
    return shift(surface, box) > LARGEST_SHIFT
