"""How fast a surface's function can change: what POV-Ray's isosurface has to know so as to step over no root."""

from __future__ import annotations

import numpy as np

from raytruth.converters.mesh.placed import Placed
from raytruth.reference_tracer.numbers import Dual, Interval

CELLS = 24  # of the container along each axis
LOOSE = 2.0  # an enclosure this much above the values found is no better than them
SPARE = 1.2  # over the largest value found, where nothing is enclosed


def max_gradient(placed: Placed, box: np.ndarray) -> tuple[float, bool]:
    """A bound of |grad f| of the regular form on `box` (2, 3), in the surface's own frame, and whether it is proven.

    An enclosure by intervals where that is tight: then it is a proof. Where the gradient has a pole (the heart's along
    its axis), or intervals say little, it is the largest value found, and POV-Ray's own warning has to confirm it.
    """
    edges = [np.linspace(*box[:, k], CELLS + 1) for k in range(3)]
    cells = Dual.axes(tuple(Interval(low, high) for low, high in
                            zip(np.ix_(*(e[:-1] for e in edges)), np.ix_(*(e[1:] for e in edges)))))
    with np.errstate(all="ignore"):
        f = placed.surface.regular(*cells)
        squares = [Interval.of(f.derivative(k)) ** 2 for k in range(3)]
        proven = float(np.sqrt(np.max(sum(s.high for s in squares))))
    middles = np.stack(np.meshgrid(*((e[:-1] + e[1:]) / 2 for e in edges), indexing="ij"), axis=-1).reshape(-1, 3)
    lengths = np.linalg.norm(placed.gradient(np.concatenate([middles, _corners_of(edges)]))[1], axis=1)
    found = float(np.max(lengths[np.isfinite(lengths)], initial=0.0))
    return (proven, True) if proven <= LOOSE * found else (SPARE * found if found > 0 else 1.0, False)


def _corners_of(edges) -> np.ndarray:
    return np.stack(np.meshgrid(*edges, indexing="ij"), axis=-1).reshape(-1, 3)
