"""All rays of one pixel: traced once more by the reference, or what another renderer's planes tell of the first."""

from __future__ import annotations

import numpy as np

from reference_tracer.tracer import render
from reference_tracer.scene.model import Scene

from .records import History, Ray

MOST_RAYS = 64  # shown of a pixel


class _Recorder(render.Watch):
    """Notes what every ray of one pixel meets."""

    def __init__(self, scene: Scene, pixel: int):
        self.scene, self.pixel, self.rays = scene, pixel, []

    def begin(self, world, first, count):
        self.world, self.first = world, first

    def observe(self, wave, interaction) -> None:
        numpy = lambda array: np.atleast_1d(array.numpy()).T
        wide = lambda array, count: np.broadcast_to(array, (count, *array.shape[1:]))
        slot = numpy(wave.slot)
        weight = wide(numpy(wave.weight), len(slot))
        mine = np.flatnonzero((slot + self.first == self.pixel) & (weight > 0))
        if not len(mine):
            return
        pick = lambda array: wide(numpy(array), len(slot))[mine]
        index, refracted = pick(interaction.hit.index), None if wave.refracted is None else pick(wave.refracted)
        columns = [pick(c) for c in (interaction.hit.t, interaction.point, interaction.normal, interaction.lights_reached,
                                     interaction.color)]
        for k, (t, point, normal, lights, color) in enumerate(zip(*columns)):
            hit = index[k] < self.world.object_count
            kind = "camera" if wave.generation == 0 else \
                "refraction" if refracted is not None and refracted[k] else "reflection"
            self.rays.append(Ray(
                generation=wave.generation, kind=kind, object=name_of(self.scene, int(index[k])) if hit else None,
                t=float(t) if hit else None, point=triple(point) if hit else None, normal=triple(normal) if hit else None,
                lights=int(lights) if hit else None, weight=float(weight[mine[k]]), color=triple(color)))


def ours(scene: Scene, row: int, col: int, method: str, title: str) -> History:
    """The rays of pixel (row, col) as the reference traces them."""
    recorder = _Recorder(scene, row * scene.camera.width + col)
    render.render(scene, method, watch=recorder)
    return shortened(title, recorder.rays)


def of_planes(picture: render.Picture, row: int, col: int, title: str) -> History:
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
    note = f"the first {MOST_RAYS} of {len(rays)} rays" if len(rays) > MOST_RAYS else ""
    return History(renderer=title, rays=rays[:MOST_RAYS], note=note)
