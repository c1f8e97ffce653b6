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
    residual: float | None  # largest distance of a vertex from the surface, to first order; None: not measurable
    error: float | None  # an upper bound of the triangles' distance from the surface, see error.py; None: not measurable
    error_p99: float | None  # what 99 % of the points looked at keep: an edge or a tip of the surface does not touch it
    normal_error: float | None  # the angle between interpolated normals and grad f, in radians, that 99 % of the points looked
    # at keep; None: not measurable
    closed: bool  # whether the surface is bounded, so that the mesh must be watertight
    clipped: str  # what was cut off or may have been, in one sentence; empty for a surface that is proven to be bounded
    seconds: float  # that it took to make it, whoever made it

    def __post_init__(self):
        for array in (self.vertices, self.faces, self.normals):  # several scenes may share them
            array.flags.writeable = False

    @property
    def nbytes(self) -> int:
        return self.vertices.nbytes + self.faces.nbytes + self.normals.nbytes

    @property
    def triangles(self) -> int:
        return len(self.faces)

    @property
    def tilt(self) -> float:
        """How far facets turn from the surface, in radians: a parabola of height `error_p99` over an edge of typical length l
        has slope 4 error_p99 / l at its ends. 0 where the error is not measurable."""
        if not self.triangles or not self.error_p99:
            return 0.0
        a, b = self.vertices[self.faces[:, 0]], self.vertices[self.faces[:, 1]]
        return float(4 * self.error_p99 / np.median(np.linalg.norm(a - b, axis=1)))
