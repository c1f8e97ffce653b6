"""Proofs about regions of space: a condition that holds on every cell of a box, cells halved where it is not seen yet."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from raytruth.reference_tracer.numbers import Interval
from raytruth.reference_tracer.scene.model import Object
from raytruth.reference_tracer.scene.placement import rotation_matrix

PARTS = 8  # cells along each axis at first
ROUNDS = 5  # of halving them
MOST_CELLS = 1 << 18


def holds_everywhere(box: np.ndarray, *conditions: Callable) -> bool:
    """Whether at every point of `box` one of `conditions` holds; each proves itself on cells (2, 3, n), or does not."""
    edges = [np.linspace(*box[:, k], PARTS + 1) for k in range(3)]
    grid = lambda ends: np.stack([a.ravel() for a in np.meshgrid(*ends, indexing="ij")])
    cells = np.stack([grid([e[:-1] for e in edges]), grid([e[1:] for e in edges])])
    for _ in range(ROUNDS):
        cells = cells[..., ~np.logical_or.reduce([condition(cells) for condition in conditions])]
        if not cells.shape[-1] or 8 * cells.shape[-1] > MOST_CELLS:
            break
        cells = _halved(cells)
    return cells.shape[-1] == 0


def _halved(cells: np.ndarray) -> np.ndarray:
    for axis in range(3):
        lower, upper = cells.copy(), cells.copy()
        lower[1, axis] = upper[0, axis] = (cells[0, axis] + cells[1, axis]) / 2
        cells = np.concatenate([lower, upper], axis=-1)
    return cells


def enclosed(obj: Object, cells: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Bounds of the regular form of `obj` on cells (2, 3, n) of world space; NaN, where it has none, proves nothing."""
    turn, center = rotation_matrix(obj.rotation), obj.surface.center
    world = [Interval(*cells[:, k]) - center[k] for k in range(3)]
    with np.errstate(all="ignore"):
        f = obj.surface.regular(*(sum(world[i] * float(turn[i, k]) for i in range(3)) for k in range(3)))
    return f.low, f.high


def no_part_of(obj: Object) -> Callable:
    """The condition that a cell holds nothing of the surface of `obj`."""
    def condition(cells):
        low, high = enclosed(obj, cells)
        return (low > 0) | (high < 0)
    return condition
