"""What trimesh says of a mesh: whether it encloses a solid, its topology, area and volume."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .mesh import Mesh


@dataclass(frozen=True)
class Check:
    """The facts a comparison reports of a mesh."""

    watertight: bool  # every edge belongs to exactly two triangles
    consistent: bool  # neighbours run the same way round
    euler_number: int  # vertices - edges + faces: 2 for a sphere, 0 for a torus
    area: float
    volume: float  # enclosed; positive if the winding is outward
    finite: bool

    def faults(self, mesh: Mesh) -> list[str]:
        """What is wrong with `mesh`, in words; empty for a sound one."""
        found = []
        if not self.finite:
            found.append("has vertices or normals that are not finite")
        if not self.consistent:
            found.append("has neighbouring triangles that run opposite ways")
        if mesh.closed and mesh.triangles and not self.watertight:
            found.append("is not watertight, though its surface is bounded")
        return found


def check(mesh: Mesh) -> Check:
    """Checks `mesh` with trimesh, an implementation that shares no code with the mesher."""
    import trimesh  # slow to import, and only reports need it

    shape = trimesh.Trimesh(mesh.vertices, mesh.faces, process=False)
    return Check(bool(shape.is_watertight), bool(shape.is_winding_consistent), int(shape.euler_number),
                 float(shape.area), float(shape.volume),
                 bool(np.isfinite(mesh.vertices).all() and np.isfinite(mesh.normals).all()))
