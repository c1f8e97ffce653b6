"""All rays of one pixel: traced once more by the reference, or what another renderer's planes tell of the first."""

from __future__ import annotations

import sys

import numpy as np

from reference_tracer.backend import backend
from reference_tracer.render import Picture
from reference_tracer.scene.model import Scene

from .records import History, Ray

MOST_RAYS = 64  # shown of a pixel
TOO_MANY = "the first {} of {} rays"


def ours(scene: Scene, row: int, col: int, method: str, title: str) -> History:
    """The rays of pixel (row, col) as the reference traces them."""
    # by way of the modules: a fault may have been put into them
    render, wavefront, world_module = (sys.modules[f"reference_tracer.{name}"] for name in ("render", "wavefront", "world"))
    world = world_module.World(scene, method, backend())
    samples, rays = scene.tracing.samples, []

    def observe(wave, collision) -> None:
        column = lambda array: np.atleast_1d(array.numpy()).T
        slot = column(wave.weight) > 0
        index, refracted = column(collision.hit.index), None if wave.refracted is None else column(wave.refracted)
        values = {"t": column(collision.hit.t), "point": column(collision.point), "normal": column(collision.normal),
                  "color": column(collision.color)}
        weight, lights = column(wave.weight), column(collision.lights_reached)
        for k in np.flatnonzero(np.broadcast_to(slot, len(values["point"]))):
            pick = lambda array: array[k if len(array) > 1 else 0]
            hit = pick(index) < world.object_count
            kind = "camera" if wave.generation == 0 else \
                "refraction" if refracted is not None and pick(refracted) else "reflection"
            rays.append(Ray(
                generation=wave.generation, kind=kind, object=name_of(scene, int(pick(index))) if hit else None,
                t=float(pick(values["t"])) if hit else None, point=triple(pick(values["point"])) if hit else None,
                normal=triple(pick(values["normal"])) if hit else None, lights=int(pick(lights)) if hit else None,
                weight=float(pick(weight)), color=triple(pick(values["color"]))))

    first = row * scene.camera.width + col
    wavefront.trace(world, render.camera_wave(world, world.camera_sides(), first, 1, samples), 2, observe)
    return shortened(title, rays)


def of_planes(picture: Picture, row: int, col: int, title: str) -> History:
    """The camera's ray through the pixel's centre, from a picture's planes."""
    hit = int(picture.index[row, col]) >= 0
    finite = lambda plane: triple(plane[row, col]) if hit and np.isfinite(plane[row, col]).all() else None
    return History(renderer=title, rays=[Ray(
        generation=0, kind="camera", object=name_of(picture.scene, int(picture.index[row, col])) if hit else None,
        t=float(picture.t[row, col]) if hit and np.isfinite(picture.t[row, col]) else None,
        point=finite(picture.position), normal=finite(picture.normal), color=None)],
        note="it tells no more than the first hit and the pixel's colour")


def name_of(scene: Scene, index: int) -> str:
    obj = scene.objects[index]
    return obj.name or f"{obj.surface.type} {index + 1}"


def triple(values) -> tuple[float, float, float]:
    return tuple(float(v) for v in values)


def shortened(title: str, rays: list[Ray]) -> History:
    """The rays in the order of their generations, the weightiest first."""
    rays = sorted(rays, key=lambda r: (r.generation, -(r.weight or 0)))
    note = TOO_MANY.format(MOST_RAYS, len(rays)) if len(rays) > MOST_RAYS else ""
    return History(renderer=title, rays=rays[:MOST_RAYS], note=note)
