"""Objects as Mitsuba shapes: native where Mitsuba has the exact one, triangle meshes else."""

from __future__ import annotations

import numpy as np

from raytruth.converters.mesh import Mesh
from raytruth.converters.mesh.placed import Placed
from raytruth.converters.mesh.sheets import Patch, plane_patch
from raytruth.reference_tracer.scene.model import Object, Scene
from raytruth.reference_tracer.scene.placement import reach_in_frame
from raytruth.reference_tracer.surfaces import Plane, Sphere

from .variant import mi


def native(obj: Object, scene: Scene, dress: dict | None = None) -> tuple[mi.Shape, str] | None:
    """The exact Mitsuba shape of `obj`, normals out of the solid, and what was clipped; None where Mitsuba has none.

    `dress` holds the plugins it wears: "bsdf", "emitter".
    """
    found = native_parts(obj, scene)
    return (mi.load_dict({**found[0], **(dress or {})}), found[1]) if found else None


def native_parts(obj: Object, scene: Scene) -> tuple[dict, str] | None:
    """The same as the dictionary that Mitsuba makes a shape of.

    An instance of a sphere can be stretched to an ellipsoid, but is intersected in fp32: its error of 3e-8 times
    (distance / semi-axis)^2, 6e-3 for a semi-axis of 0.1 at distance 3, is that of no exact shape.
    """
    match obj.surface:
        case Sphere() as s:
            return {"type": "sphere", "center": list(s.center), "radius": s.r, "flip_normals": s.inside == "positive"}, ""
        case Plane() as s:
            placed = Placed(obj)
            patch = plane_patch(s, reach_in_frame(scene, obj))
            return (_rectangle(placed, patch), patch.clipped) if patch else None
    return None


def meshed(mesh: Mesh, name: str) -> mi.Shape:
    """`mesh`, which must have faces, as a Mitsuba mesh with vertex normals."""
    shape = mi.Mesh(name, len(mesh.vertices), mesh.triangles, has_vertex_normals=True, props=mi.Properties())
    parameters = mi.traverse(shape)
    parameters["vertex_positions"] = mi.Float(mesh.vertices.astype(np.float32).ravel())
    parameters["vertex_normals"] = mi.Float(mesh.normals.astype(np.float32).ravel())
    parameters["faces"] = mi.UInt32(mesh.faces.astype(np.uint32).ravel())
    parameters.update()
    return shape


def _rectangle(placed: Placed, patch: Patch) -> dict:
    """Mitsuba's rectangle [-1, 1]^2 with normal z, laid onto `patch`."""
    axes = np.stack([patch.half * patch.u, patch.half * patch.v, np.cross(patch.u, patch.v)])
    to_world = np.eye(4)
    to_world[:3, :3] = placed.turned(axes).T
    to_world[:3, 3] = placed.to_world(patch.middle[None])[0]
    return {"type": "rectangle", "to_world": mi.ScalarTransform4f(to_world)}
