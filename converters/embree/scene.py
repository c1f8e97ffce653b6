"""A scene of implicit surfaces as meshes that Embree intersects.

Every object gets an acceleration structure of its own: trimesh shifts and scales each to a box that suits Embree's fp32,
so that a floor 200 wide does not cost the ball on it its digits. Embree only picks the triangle; where the ray meets
its plane is then found in fp64.
"""

from __future__ import annotations

import time
from dataclasses import dataclass

import numpy as np
import trimesh

from raytruth.converters.mesh import Mesh, mesh_object
from raytruth.reference_tracer.errors import MissingError
from raytruth.reference_tracer.scene.model import Scene

OFFSET = 1e-6  # of an object's size: about ten units in the last place of Embree's fp32 coordinates


class Solid:
    """One object's mesh in Embree."""

    def __init__(self, mesh: Mesh):
        """Raises MissingError without embreex."""
        try:
            from trimesh.ray.ray_pyembree import RayMeshIntersector
        except ImportError:
            raise MissingError("embreex is not installed; 'pip install embreex' brings it") from None
        self.error, self.clipped, self.tilt, self.normal_error = mesh.error, mesh.clipped, mesh.tilt, mesh.normal_error
        self.normals = mesh.normals
        self.mesh = trimesh.Trimesh(mesh.vertices, mesh.faces, process=False, validate=False)
        corners = np.asarray(self.mesh.triangles)
        facets = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        with np.errstate(invalid="ignore"):  # a triangle without area, which no ray meets
            self.facets = facets / np.linalg.norm(facets, axis=1, keepdims=True)
        self.corners = corners
        # most rays miss a small object: a ball around it is asked before the hierarchy
        low, high = self.mesh.bounds
        self.middle, self.radius = (low + high) / 2, float(np.linalg.norm(high - low)) / 2 + 1e-9
        self.offset = OFFSET * float(self.mesh.scale)
        self.intersector = RayMeshIntersector(self.mesh)

    def meet(self, o, d) -> tuple[np.ndarray, np.ndarray]:
        """The rays (k,) that meet a triangle, and the first one each meets; o and d are (n, 3), d unit."""
        to_middle = self.middle - o
        nearest = np.einsum("ij,ij->i", to_middle, d)
        away = to_middle - nearest[:, None] * d
        ray = np.flatnonzero((np.einsum("ij,ij->i", away, away) <= self.radius**2) & (nearest > -self.radius))
        if not len(ray):  # which the intersector does not take
            return ray, ray
        triangle = self.intersector.intersects_first(o[ray], d[ray])
        return ray[triangle >= 0], triangle[triangle >= 0]

    def distance(self, o, d, triangle):
        """(t, slope): where each ray meets its triangle's plane, and the cosine between d and the facet's normal."""
        slope = np.einsum("ij,ij->i", d, self.facets[triangle])
        with np.errstate(divide="ignore", invalid="ignore"):
            t = np.einsum("ij,ij->i", self.corners[triangle, 0] - o, self.facets[triangle]) / slope
        return t, slope

    def behind(self, p, d, facet):
        """Points off a facet through p, on the side that d points to."""
        towards = np.einsum("ij,ij->i", d, facet)
        return p + np.copysign(self.offset, towards)[:, None] * facet

    def normal(self, p, triangle):
        """The vertex normals (n, 3), interpolated at points of the triangles' planes, unit, out of the solid."""
        weights = trimesh.triangles.points_to_barycentric(self.corners[triangle], p)
        normal = np.einsum("ij,ijk->ik", weights, self.normals[self.mesh.faces[triangle]])
        return normal / np.linalg.norm(normal, axis=1, keepdims=True)


@dataclass(frozen=True)
class EmbreeScene:
    """A converted scene."""

    solids: tuple[Solid | None, ...]  # in scene order; None where no ray can meet the object
    seconds: float  # spent on meshes, whoever made them, and on Embree's structures

    @property
    def triangles(self) -> int:
        return sum(len(solid.facets) for solid in self.solids if solid)


def convert(scene: Scene, resolution: int = 256) -> EmbreeScene:
    """`scene` as meshes of `resolution` cells along their longest side, the same that Mitsuba is given.

    Raises InputError for impossible meshes, MissingError without embreex.
    """
    meshes = [mesh_object(obj, scene, resolution) for obj in scene.objects]
    start = time.perf_counter()
    solids = tuple(Solid(mesh) if mesh.triangles else None for mesh in meshes)
    for solid in solids:
        if solid:  # trimesh builds the structure at the first query
            solid.meet(np.zeros((1, 3)), np.array([[0.0, 0.0, 1.0]]))
    return EmbreeScene(solids, sum(mesh.seconds for mesh in meshes) + time.perf_counter() - start)
