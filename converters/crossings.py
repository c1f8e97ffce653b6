"""What every tracer of ours that is written in NumPy asks of whoever finds hits for it: crossings of arrays of rays.

The side of every object is inherited (decision M3): a hit whose direction through the surface contradicts that side is no
crossing, and the ray goes on behind it.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np


@dataclass
class Hit:
    """The first crossing of each of n rays."""

    t: np.ndarray  # (n,), infinity where nothing was hit
    index: np.ndarray  # (n,) object in scene order, -1 where nothing was hit
    facet: np.ndarray  # (n, 3) unit normal of the shape that was hit, out of the solid
    normal: np.ndarray  # (n, 3) unit, of the surface, turned against the ray (decision N1)
    lost: np.ndarray  # (n,) undecided


@dataclass
class Start:
    """Where rays start: o (n, 3), the object each leaves (-1: none) and the facet (n, 3) it leaves it by."""

    o: np.ndarray
    left: np.ndarray
    facet: np.ndarray

    def of(self, which) -> Start:
        return Start(self.o[which], self.left[which], self.facet[which])


class Crossings(Protocol):
    """The queries of a tracer on a scene. `d` is (n, 3) unit, `inside` (n, objects): which solids a ray is in."""

    def first_hit(self, start: Start, d: np.ndarray, inside: np.ndarray, reach: np.ndarray) -> Hit:
        """The first crossing of each ray with any object within `reach` (n,) (decisions M5, F4)."""

    def transmittance(self, start: Start, d: np.ndarray, distance: np.ndarray, inside: np.ndarray
                      ) -> tuple[np.ndarray, np.ndarray]:
        """The part of a light that arrives from `distance` away, transparency at every crossing (decision L3), and
        whether that is undecided: (n,) each."""
