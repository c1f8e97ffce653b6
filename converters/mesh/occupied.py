"""Where a surface can be: interval arithmetic strikes out the boxes it provably does not pass through."""

from __future__ import annotations

import numpy as np

from raytruth.reference_tracer.numbers import Interval

from .placed import Placed

PARTS = 32  # boxes along each axis in one round of `tight_box`
ROUNDS = 12


def may_hold(placed: Placed, low, high) -> np.ndarray:
    """Whether the surface may pass through the boxes [low, high], two broadcast triples of arrays; False is a proof.

    An enclosure of f over a box that excludes zero leaves no room for a crossing (Moore, Interval Analysis, 1966).
    """
    with np.errstate(all="ignore"):
        f = placed.surface.regular(*(Interval(a, b) for a, b in zip(low, high)))
        excluded = f.excludes_zero()
    return ~np.broadcast_to(excluded, np.broadcast_shapes(*(np.shape(a) for a in low)))


def tight_box(placed: Placed, box: np.ndarray) -> np.ndarray | None:
    """(2, 3): the smallest box found that holds all of the surface within `box`; None if there is none."""
    for _ in range(ROUNDS):
        edges = [np.linspace(box[0, k], box[1, k], PARTS + 1) for k in range(3)]
        held = may_hold(placed, np.ix_(*(e[:-1] for e in edges)), np.ix_(*(e[1:] for e in edges)))
        indices = np.nonzero(held)
        if not len(indices[0]):
            return None
        tight = np.array([[edges[k][indices[k].min()] for k in range(3)],
                          [edges[k][indices[k].max() + 1] for k in range(3)]])
        if np.all(tight[1] - tight[0] > 0.9 * (box[1] - box[0])):
            return tight
        box = tight
    return box
