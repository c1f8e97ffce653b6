"""Hits on meshes moved onto f = 0 by Newton's method in fp64: Mitsuba says which surface a ray meets and about where.

What is left is the error of shading alone. The surface is then f's own, evaluated by the code that the reference uses:
agreement says nothing of meshes or of roots.
"""

from __future__ import annotations

import numpy as np

from raytruth.reference_tracer.numbers import Dual
from raytruth.reference_tracer.scene.model import Object
from raytruth.reference_tracer.scene.placement import rotation_matrix

from .variant import dr, mi

STEPS = 4  # from a mesh's error of 1e-4: 1e-8, 1e-16, and two for steep and curved places
FARTHEST = 20.0  # of the mesh's error along the normal: beyond it the ray passes the surface by, and keeps its hit


class Refinement:
    """The objects of a scene that stand as meshes: `errors` maps each one's index to its largest distance from f."""

    def __init__(self, objects: tuple[Object, ...], errors: dict[int, float]):
        self.objects = {k: (objects[k].surface, rotation_matrix(objects[k].rotation)) for k in errors}
        self.errors = {k: dr.opaque(mi.Float64, float(error)) for k, error in errors.items()}

    def refined(self, o, d, t, normal, index, active):
        """`t`, the place and the normal (out of the solid) of hits at distance `t` along o + t d, refined on meshes."""
        p = dr.fma(d, t, o)
        for k, (surface, turn) in self.objects.items():
            local_o, local_d = self._local(surface, turn, o, d)
            mine, t64 = active & (index == k), mi.Float64(t)
            steep = dr.abs(mi.Float64(dr.dot(d, normal)))
            start = t64
            for _ in range(STEPS):
                g = surface.regular(*Dual.along([a + b * t64 for a, b in zip(local_o, local_d)], local_d))
                step = g.value / g.derivative()
                t64 -= dr.select(dr.isfinite(step), step, 0)
            mine &= dr.abs(t64 - start) * steep <= FARTHEST * self.errors[k]
            point = [a + b * t64 for a, b in zip(local_o, local_d)]
            gradient = surface.regular(*Dual.axes(point))
            n = [gradient.derivative(i) for i in range(3)]
            n = mi.Vector3f(*(mi.Float(sum(float(turn[i, j]) * n[j] for j in range(3))) for i in range(3)))
            length = dr.norm(n)
            usable = mine & dr.isfinite(length) & (length > 0)
            t = dr.select(mine, mi.Float(t64), t)
            placed = [sum(float(turn[i, j]) * point[j] for j in range(3)) + surface.center[i] for i in range(3)]
            p = dr.select(mine, mi.Point3f(*(mi.Float(c) for c in placed)), p)
            normal = dr.select(usable, n / length, normal)
        return t, p, normal

    @staticmethod
    def _local(surface, turn: np.ndarray, o, d):
        """Origin and direction in the surface's own frame, triples of fp64."""
        moved = [mi.Float64(o[i]) - surface.center[i] for i in range(3)]
        along = [mi.Float64(d[i]) for i in range(3)]
        into = lambda v: [sum(float(turn[i, j]) * v[i] for i in range(3)) for j in range(3)]
        return into(moved), into(along)
