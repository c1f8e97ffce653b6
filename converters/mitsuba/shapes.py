"""Objects as Mitsuba shapes: native where Mitsuba has the exact one, triangle meshes else."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from converters.mesh import Mesh
from converters.mesh.placed import Placed
from converters.mesh.reach import reach_in_frame
from converters.mesh.sheets import plane_patch
from reference_tracer.scene.model import Object, Scene
from reference_tracer.surfaces import Ellipsoid, Plane, Sphere

from .variant import mi


@dataclass(frozen=True)
class Shape:
    """What stands for one object: the shape that intersections report, and the entries it needs in a scene."""

    kind: str
    reported: mi.Shape
    entries: dict


def native(obj: Object, scene: Scene, name: str) -> Shape | None:
    """The exact Mitsuba shape of `obj`, normals out of the solid, or None where Mitsuba has none."""
    flipped = obj.surface.inside == "positive"
    match obj.surface:
        case Sphere() as s:
            sphere = mi.load_dict({"type": "sphere", "center": list(s.center), "radius": s.r, "flip_normals": flipped})
            return Shape("sphere", sphere, {name: sphere})
        case Ellipsoid() as s:
            # a sphere refuses to be stretched, but an instance of one may be
            sphere = mi.load_dict({"type": "sphere", "flip_normals": flipped})
            placed = Placed(obj)
            to_world = _transform(placed, np.zeros(3), np.diag([s.a, s.b, s.c]))
            return Shape("stretched sphere", sphere, {
                f"{name}-group": {"type": "shapegroup", "sphere": sphere},
                name: {"type": "instance", "to_world": to_world, "group": {"type": "ref", "id": f"{name}-group"}}})
        case Plane() as s:
            placed = Placed(obj)
            patch = plane_patch(s, reach_in_frame(scene, placed))
            if patch is None:
                return None
            axes = np.stack([patch.half * patch.u, patch.half * patch.v, np.cross(patch.u, patch.v)], axis=1)
            rectangle = mi.load_dict({"type": "rectangle", "to_world": _transform(placed, patch.middle, axes)})
            return Shape("rectangle", rectangle, {name: rectangle})
    return None


def meshed(mesh: Mesh, name: str) -> Shape:
    """`mesh`, which must have faces, as a Mitsuba mesh with vertex normals."""
    shape = mi.Mesh(name, mesh.vertices.shape[0], mesh.triangles, has_vertex_normals=True, props=mi.Properties())
    parameters = mi.traverse(shape)
    parameters["vertex_positions"] = mi.Float(mesh.vertices.astype(np.float32).ravel())
    parameters["vertex_normals"] = mi.Float(mesh.normals.astype(np.float32).ravel())
    parameters["faces"] = mi.UInt32(mesh.faces.astype(np.uint32).ravel())
    parameters.update()
    return Shape("mesh", shape, {name: shape})


def _transform(placed: Placed, middle: np.ndarray, axes: np.ndarray) -> mi.ScalarTransform4f:
    """The affine map x -> middle + axes x in the frame of `placed`, taken into the world; `axes` (3, 3) by columns."""
    matrix = np.eye(4)
    matrix[:3, :3] = placed.turned(axes.T).T
    matrix[:3, 3] = placed.to_world(middle[None])[0]
    return mi.ScalarTransform4f(matrix)
