"""raysect on a scene: another team's closed forms in double precision, and the document's shading evaluated on their hits.

A witness of geometry and shadows that shares no root finder with the reference: planes, spheres, ellipsoids, tori,
paraboloids, and what is clipped of them. It is optional, and asked ray by ray: small pictures only.
"""

from __future__ import annotations

import time

import numpy as np

from raytruth.converters.raysect import RaysectIntersector, error
from raytruth.reference_tracer.scene.model import Scene
from raytruth.reference_tracer.tracer.render import UNDECIDED, Picture

from ..execution.code import installed
from .document_shading import traced


def render(scene: Scene) -> Picture:
    """The picture of `scene` on raysect's primitives.

    Raises UnsupportedError for a surface that raysect has no primitive for, MissingError without raysect.
    """
    begin = time.perf_counter()
    crossings = RaysectIntersector(scene)
    start, cpu = time.perf_counter(), time.process_time()
    picture, rays = traced(scene, crossings)
    seconds, cpu = time.perf_counter() - start, time.process_time() - cpu
    picture.metadata = {
        "scene": scene.name, "scene_hash": scene.hash, "renderer": "raysect", "raysect": installed("raysect"), "precision": 64,
        "errors": [error(obj.surface) for obj in scene.objects],
        "rays": rays, "undecided pixels": int(np.sum(picture.status == UNDECIDED)),
        # nothing is compiled: the first is a warm one
        "build": start - begin, "first": seconds, "warm": seconds, "cpu": cpu}
    return picture
