"""A scene of implicit surfaces as a Mitsuba scene."""

from __future__ import annotations

import time
from dataclasses import dataclass

import numpy as np

from raytruth.converters.mesh import mesh_object, mesh_to_error, require_settings
from raytruth.converters.mesh.placed import Placed
from raytruth.reference_tracer.backend import backend
from raytruth.reference_tracer.errors import InputError
from raytruth.reference_tracer.scene.model import Scene

from .grid import grid
from .sensor import sensor
from .shapes import meshed, native
from .variant import dr, mi

SHAPES = ("native", "mesh", "sdfgrid")


@dataclass(frozen=True)
class Part:
    """How one object was converted."""

    kind: str  # one of SHAPES, or "nothing" where no ray can meet it
    triangles: int
    error: float | None  # an upper bound of the distance between a mesh and the surface (of a grid, the largest one
    # found), before Mitsuba rounds it to fp32; None: not measurable
    clipped: str  # what was cut off, see Mesh
    tilt: float = 0.0  # of facets against the surface, see Mesh
    normal_error: float | None = 0.0  # of interpolated normals, in radians, see Mesh


@dataclass(frozen=True)
class MitsubaScene:
    """A converted scene."""

    scene: mi.Scene
    sensor: mi.Sensor | None  # None for a camera that Mitsuba has no sensor for (decision F5): its rays are to be given
    index_of_shape: np.ndarray  # (k,) uint32: the object in scene order of the shape with that registry id
    parts: tuple[Part, ...]  # in scene order
    seconds: float  # spent on meshes and on Mitsuba's own structures

    @property
    def triangles(self) -> int:
        return sum(part.triangles for part in self.parts)


def convert(scene: Scene, shapes: str = "native", resolution: int = 256, error: float | None = None,
            share: float = 1.0) -> MitsubaScene:
    """`scene` for Mitsuba, no files in between.

    `shapes` "native" takes Mitsuba's own sphere and rectangle and meshes for the rest, "mesh" takes meshes only,
    "sdfgrid" takes grids for what is bounded and native shapes or meshes for the rest.
    Meshes have `resolution` cells along their longest side; or, if `error` is given in units of the scene, they keep
    it on that `share` of the surface (see `mesh_to_error`). Raises InputError for impossible meshes.
    """
    if shapes not in SHAPES:
        raise InputError(f"shapes must be one of {', '.join(SHAPES)}; found {shapes!r}")
    if shapes != "sdfgrid":  # a grid says itself what it needs
        require_settings(resolution, error, share)
    if share != 1 and error is None:
        raise InputError(f"share says how much of a mesh keeps its error: give the error as well; found share {share} alone")
    backend()  # a machine without LLVM is told so in one line
    start = time.perf_counter()
    made, parts = {}, []
    for index, obj in enumerate(scene.objects):
        placed = Placed(obj)
        gridded = shapes == "sdfgrid" and placed.region is not None
        exact = native(obj, scene) if shapes != "mesh" and not gridded else None
        if gridded:
            shape, distance, turn = grid(placed, resolution)
            part = Part("sdfgrid", 0, distance, placed.unproven, normal_error=turn)
        elif exact:
            shape, part = exact[0], Part("native", 0, 0.0, exact[1])
        else:
            asked = time.perf_counter()
            mesh = (mesh_object(obj, scene, resolution) if error is None
                    else mesh_to_error(obj, scene, error, share))
            start += time.perf_counter() - asked - mesh.seconds  # it may have been made before, for another renderer
            shape = meshed(mesh, f"object-{index}") if mesh.triangles else None
            part = Part("mesh" if shape else "nothing", mesh.triangles, mesh.error, mesh.clipped, mesh.tilt,
                        mesh.normal_error)
        if shape:
            made[index] = shape
        parts.append(part)
    converted = mi.load_dict({"type": "scene", "embree_use_robust_intersections": True,
                              **{f"object-{index}": shape for index, shape in made.items()}})
    dr.sync_thread()
    seen_by = None if scene.camera.is_oblique else sensor(scene.camera)
    return MitsubaScene(converted, seen_by, _table(made), tuple(parts), time.perf_counter() - start)


def _table(shapes: dict[int, mi.Shape]) -> np.ndarray:
    ids = {index: int(dr.reinterpret_array(mi.UInt32, mi.ShapePtr(shape))[0]) for index, shape in shapes.items()}
    table = np.zeros(max(ids.values(), default=0) + 1, np.uint32)
    for index, place in ids.items():
        table[place] = index
    return table
