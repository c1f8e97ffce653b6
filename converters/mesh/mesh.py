"""What meshing returns."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Mesh:
    """Triangles that stand for one object of a scene, in world space.

    Corners run counter-clockwise seen from outside the solid. A mesh without faces means that no ray of the scene can
    meet the object.
    """

    vertices: np.ndarray  # (n, 3) fp64, on f = 0
    faces: np.ndarray  # (m, 3) int64, indices of vertices
    normals: np.ndarray  # (n, 3) fp64, unit, grad f at the vertices: out of the solid
    resolution: int  # cells along the longest side
    residual: float  # largest distance of a vertex from the surface
    error: float  # largest distance of a triangle from the surface, measured at centroids and middles of edges
    error_p99: float  # the distance that 99 % of those points keep: an edge or a tip of the surface does not touch it
    closed: bool  # whether the surface is bounded, so that the mesh must be watertight
    clipped: str  # what was cut off, in one sentence; empty for a bounded surface

    @property
    def triangles(self) -> int:
        return len(self.faces)
