"""All rays of a pixel as Mitsuba's renderer traces them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from raytruth.converters.mitsuba import convert
from raytruth.converters.mitsuba.variant import dr, mi
from raytruth.reference_tracer.scene.model import Scene

from ..renderers.mitsuba import _Rays, _Tracer
from .document import History, Ray
from .rays import ray_of, shortened


def rays(scene: Scene, places: Sequence[tuple[int, int]], title: str, shapes: str, resolution: int) -> list[History]:
    """The rays of each of the pixels (row, col)."""
    tracer, found = _Recording(scene, convert(scene, shapes, resolution)), []
    for row, col in places:
        tracer.recorded = []
        tracer.trace(tracer._camera_rays(row * scene.camera.width + col, 1, scene.tracing.samples), 2)
        found.append(shortened(title, tracer.recorded))
    return found


class _Recording(_Tracer):
    """Notes what every ray meets. A queue of rays carries the generation and the parents it was made from."""

    def __init__(self, *arguments):
        super().__init__(*arguments)
        self.recorded: list[Ray] = []

    def _interact(self, rays: _Rays):
        hit, color, unsure, secondary = super()._interact(rays)
        count = dr.width(rays.slot)

        def numpy(array):
            columns = np.atleast_1d(array.numpy()).T
            return np.broadcast_to(columns, (count, *columns.shape[1:]))

        weight, met, index = numpy(rays.weight), numpy(hit.met), numpy(hit.index)
        t, point, normal, own = numpy(hit.t), numpy(hit.p), numpy(hit.normal), numpy(mi.Vector3f(color))
        lights = numpy(self._lights_reached(hit, rays))
        kinds = self._kinds(rays)
        for k in np.flatnonzero(weight > 0):
            self.recorded.append(ray_of(self.document, getattr(rays, "generation", 0), kinds[k],
                                        int(index[k]) if met[k] else None, t[k], point[k], normal[k], lights[k], own[k],
                                        weight[k]))
        return hit, color, unsure, secondary

    def _lights_reached(self, hit, rays: _Rays):
        """How many lights alone make each point bright (UInt32): the illumination, asked one light at a time."""
        everything = self.light_position, self.light_brightness, self.lights, self.ambient
        self.ambient = 0.0
        reached = mi.UInt32(0)
        for j in range(len(self.document.lights)):
            self.light_position = [mi.Float(float(c[j])) for c in everything[0]]
            self.light_brightness = [mi.Float(1.0)] * 3
            self.lights = dr.opaque(mi.UInt32, 1)
            light, _ = self.illumination(hit, rays.sides, hit.met)
            reached += dr.select(light.x > 0, mi.UInt32(1), 0)
        self.light_position, self.light_brightness, self.lights, self.ambient = everything
        return reached

    def _queues(self, rays: _Rays, hit, secondary):
        queues = super()._queues(rays, hit, secondary)
        for queue in queues:
            queue.generation = getattr(rays, "generation", 0) + 1
            queue.parents = hit.p.numpy().T, rays.sides.words[0].numpy()
        return queues

    @staticmethod
    def _kinds(rays: _Rays) -> list[str]:
        """A refraction ray has changed its side of an object; a reflection ray keeps its parent's."""
        count = dr.width(rays.slot)
        if not getattr(rays, "generation", 0):
            return ["camera"] * count
        points, sides = rays.parents
        nearest = [int(np.argmin(np.linalg.norm(points - o, axis=1))) for o in rays.o.numpy().T]
        own = np.broadcast_to(rays.sides.words[0].numpy(), count)
        return ["reflection" if own[k] == sides[min(nearest[k], len(sides) - 1)] else "refraction" for k in range(count)]
