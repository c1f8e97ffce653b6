"""All rays of a pixel: traced once more by the reference, or what another renderer's planes tell of the first."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from raytruth.reference_tracer.scene.model import Scene
from raytruth.reference_tracer.tracer.render import Picture, Renderer, Watch

from .document import History, Ray

MOST_RAYS = 64  # shown of a pixel


class Recorder(Watch):
    """Notes what every ray of some pixels meets, a list of rays for each."""

    def __init__(self, scene: Scene, count: int):
        self.scene, self.rays = scene, [[] for _ in range(count)]

    def begin(self, world, first, count):
        self.world = world

    def observe(self, wave, interaction) -> None:
        numpy = lambda array: np.atleast_1d(array.numpy()).T
        wide = lambda array, count: np.broadcast_to(array, (count, *array.shape[1:]))
        slot = numpy(wave.slot)
        weight = wide(numpy(wave.weight), len(slot))
        mine = np.flatnonzero((slot < len(self.rays)) & (weight > 0))
        if not len(mine):
            return
        pick = lambda array: wide(numpy(array), len(slot))[mine]
        index, refracted = pick(interaction.hit.index), None if wave.refracted is None else pick(wave.refracted)
        columns = [pick(c) for c in (interaction.hit.t, interaction.point, interaction.normal, interaction.lights_reached,
                                     interaction.color)]
        for k, values in enumerate(zip(*columns, weight[mine])):
            kind = "camera" if wave.generation == 0 else \
                "refraction" if refracted is not None and refracted[k] else "reflection"
            met = int(index[k]) if index[k] < self.world.object_count else None
            self.rays[slot[mine[k]]].append(ray_of(self.scene, wave.generation, kind, met, *values))


def ours(renderer: Renderer, places: Sequence[tuple[int, int]], title: str) -> list[History]:
    """The rays of each of the pixels (row, col) as the reference tracer traces them, with all samples."""
    recorder = Recorder(renderer.scene, len(places))
    renderer.follow([row * renderer.scene.camera.width + col for row, col in places], recorder)
    return [shortened(title, rays) for rays in recorder.rays]


def of_planes(picture: Picture, row: int, col: int, title: str) -> History:
    """The camera's ray through the pixel's centre, from a picture's planes."""
    hit = int(picture.index[row, col]) >= 0
    finite = lambda plane: plane[row, col].tolist() if hit and np.isfinite(plane[row, col]).all() else None
    return History(renderer=title, rays=[Ray(
        generation=0, kind="camera", object=name_of(picture.scene, int(picture.index[row, col])) if hit else None,
        t=finite(picture.t), point=finite(picture.position), normal=finite(picture.normal), color=None)],
        note="no more is told than the first hit and the pixel's colour")


def name_of(scene: Scene, index: int) -> str:
    obj = scene.objects[index]
    return obj.name or f"{obj.surface.type} {index + 1}"


def ray_of(scene: Scene, generation: int, kind: str, met: int | None, t, point, normal, lights, color, weight) -> Ray:
    """A ray from numbers of NumPy; `met` is the object it hit, None for none."""
    hit = {} if met is None else {"object": name_of(scene, met), "t": float(t), "point": point.tolist(),
                                  "normal": normal.tolist(), "lights": int(lights)}
    return Ray(generation=generation, kind=kind, weight=float(weight), color=color.tolist(), **hit)


def shortened(title: str, rays: list[Ray]) -> History:
    """The rays in the order of their generations, the weightiest first."""
    rays = sorted(rays, key=lambda r: (r.generation, -(r.weight or 0)))
    note = f"the first {MOST_RAYS} of {len(rays)} rays" if len(rays) > MOST_RAYS else ""
    return History(renderer=title, rays=rays[:MOST_RAYS], note=note)
