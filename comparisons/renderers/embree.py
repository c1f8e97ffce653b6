"""Embree on a scene: Embree finds the intersections with meshes, and the document's shading is evaluated on them.

A second tracer on the meshes that Mitsuba is given: where the two agree, what is left is the meshes' error.
"""

from __future__ import annotations

import time
from importlib.metadata import version

import numpy as np

from raytruth.converters.embree import EmbreeIntersector, convert
from raytruth.converters.mesh import largest
from raytruth.reference_tracer.scene.model import Scene
from raytruth.reference_tracer.tracer.render import UNDECIDED, Picture

from .document_shading import traced


def render(scene: Scene, *, resolution: int = 256) -> Picture:
    """The picture of `scene` on meshes of `resolution` cells along their longest side.

    Raises InputError for impossible meshes, MissingError without embreex.
    """
    converted = convert(scene, resolution)
    start, cpu = time.perf_counter(), time.process_time()
    picture, rays = traced(scene, EmbreeIntersector(scene, converted))
    seconds, cpu = time.perf_counter() - start, time.process_time() - cpu
    solids = [(k, solid) for k, solid in enumerate(converted.solids) if solid]
    picture.metadata = {
        "scene": scene.name, "scene_hash": scene.hash, "renderer": "embree", "embreex": version("embreex"),
        "resolution": resolution, "triangles": converted.triangles,
        "measured_mesh_error": largest(solid.error for _, solid in solids), "precision": 32,
        "errors": [solid.error if solid else 0.0 for solid in converted.solids],
        "tilts": [solid.tilt if solid else 0.0 for solid in converted.solids],
        "normal_errors": [solid.normal_error if solid else 0.0 for solid in converted.solids],
        "clipped": "; ".join(f"object {k}: {solid.clipped}" for k, solid in solids if solid.clipped),
        "rays": rays, "undecided pixels": int(np.sum(picture.status == UNDECIDED)),
        # nothing is compiled: the first is a warm one
        "build": converted.seconds, "first": seconds, "warm": seconds, "cpu": cpu}
    return picture
