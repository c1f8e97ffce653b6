"""A surface at its object's place, evaluated on NumPy arrays."""

from __future__ import annotations

from functools import cached_property

import numpy as np

from raytruth.reference_tracer.numbers import Dual
from raytruth.reference_tracer.scene.model import Object
from raytruth.reference_tracer.scene.placement import corners_in_world, rotation_matrix

CHUNK = 1 << 17  # points evaluated at once: bounds the memory of the derivatives


class Placed:
    """The regular form of an object's surface in the surface's own frame, and the way from there into the world.

    Points and vectors are (n, 3) fp64. The regular form has the zeros and the signs of f, and a gradient where grad f
    vanishes (decision O5): interpolation, projection and normals all need that.
    """

    def __init__(self, obj: Object):
        self.object, self.surface = obj, obj.surface
        self._center = np.array(obj.surface.center)
        self._rotation = None if obj.rotation is None else rotation_matrix(obj.rotation)

    @cached_property
    def box(self) -> np.ndarray | None:
        """(2, 3): low and high corner of a box, in its own frame, that provably holds the surface; None without one."""
        box = self.surface.box()
        return None if box is None else np.array(box, float)

    @cached_property
    def region(self) -> np.ndarray | None:
        """(2, 3): where to look for the surface: its box, or one that is promised and not proven."""
        region = self.surface.region()
        return None if region is None else np.array(region, float)

    @property
    def unproven(self) -> str:
        """What to say of a region that is not proven to hold the surface; else ""."""
        return "" if self.region is None or self.box is not None else "bounds not proven"

    def to_world(self, points):
        return self.turned(points) + self._center

    def turned(self, vectors):
        return vectors if self._rotation is None else vectors @ self._rotation.T

    def to_own_frame(self, points):
        moved = points - self._center
        return moved if self._rotation is None else moved @ self._rotation

    def corners_in_world(self) -> np.ndarray:
        """(8, 3): the corners of the region of a surface that has one."""
        return corners_in_world(self.object, self.region)

    def values(self, x, y, z):
        """The regular form, negative inside, on broadcast coordinates; NaN counts as outside (decision M7)."""
        with np.errstate(all="ignore"):
            values = np.asarray(self.surface.regular(x, y, z), float)
        return np.where(np.isnan(values), np.inf, values)

    def gradient(self, points):
        """The regular form (n,) and its gradient (n, 3) by dual numbers."""
        values, gradients = np.empty(len(points)), np.empty((len(points), 3))
        for start in range(0, len(points), CHUNK):
            part = slice(start, start + CHUNK)
            with np.errstate(all="ignore"):
                f = self.surface.regular(*Dual.axes(tuple(np.ascontiguousarray(points[part].T))))
                values[part] = f.value
                for k in range(3):
                    gradients[part, k] = f.derivative(k)
        return values, gradients

    def distance(self, points):
        """The distance (n,) of `points` from the surface to first order, |f| / |grad f|; NaN without a gradient."""
        values, gradients = self.gradient(points)
        with np.errstate(all="ignore"):
            return np.abs(values) / np.linalg.norm(gradients, axis=1)
