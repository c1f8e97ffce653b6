"""What lies where a picture still differs: pixel classes, from what the rays of the pixel and of its neighbours meet."""

from __future__ import annotations

from collections import Counter

import numpy as np

from raytruth.reference_tracer.scene.model import Scene
from raytruth.reference_tracer.tracer.camera_rays import camera_rays
from raytruth.reference_tracer.tracer.render import Renderer
from raytruth.reference_tracer.tracer.wavefront import MOST_RAYS, Wavefront

from .pixels import METHOD

CLASSES = {
    "belt of the heart": "on the heart, near y = 0, where the gradient of the printed form vanishes (F6)",
    "silhouette": "the pixel and its neighbours see different objects",
    "shadow edge": "different lights reach what they see",
    "range end": "in mirrors or through glass, a ray of one of them still meets something where another's range has ended",
    "edge in a mirror": "rays of a later generation meet different objects",
    "shadow edge in a mirror": "different lights reach what rays of a later generation meet",
    "smooth": "nothing of this: the numbers of the scene, or rounding",
}
BELT = 0.1  # of |y| of the heart's form, whose height is about 2.3
AROUND = 9  # the pixel and its eight neighbours


def classes(scene: Scene, pixels: np.ndarray) -> Counter:
    """How many of the `pixels`, numbers in row order, are of each of `CLASSES`; the first that fits counts."""
    found = Counter()
    for start in range(0, len(pixels), MOST_RAYS // AROUND):
        found.update(_classes(scene.traced_with(samples=1), pixels[start:start + MOST_RAYS // AROUND]))
    return found


def _classes(scene: Scene, pixels: np.ndarray) -> Counter:
    camera, seen = scene.camera, _Seen(scene)
    row, column = np.divmod(pixels, camera.width)
    rows = np.clip(row[:, None] + np.repeat([-1, 0, 1], 3), 0, camera.height - 1)
    columns = np.clip(column[:, None] + np.tile([-1, 0, 1], 3), 0, camera.width - 1)
    seen.trace((rows * camera.width + columns).ravel())
    differs = lambda values: (values.reshape(len(pixels), AROUND) != values.reshape(len(pixels), AROUND)[:, :1]).any(axis=1)
    left, found = np.ones(len(pixels), bool), Counter()
    for name, fits in (("belt of the heart", seen.belt.reshape(-1, AROUND).any(axis=1)),
                       ("silhouette", differs(seen.objects[0])), ("shadow edge", differs(seen.lights[0])),
                       ("range end", _any(map(differs, seen.misses[1:]), left)),
                       ("edge in a mirror", _any(map(differs, seen.objects[1:]), left)),
                       ("shadow edge in a mirror", _any(map(differs, seen.lights[1:]), left)), ("smooth", left)):
        found[name] += int((left & fits).sum())
        left = left & ~fits
    return found


def _any(masks, like) -> np.ndarray:
    return np.logical_or.reduce([np.zeros_like(like), *masks])


class _Seen:
    """What the rays of each pixel met, generation by generation, as sums that do not depend on the order of rays."""

    def __init__(self, scene: Scene):
        self.scene, self.renderer = scene, Renderer(scene, METHOD)

    def trace(self, pixels: np.ndarray) -> None:
        count, generations = len(pixels), self.scene.tracing.max_depth + 1
        self.objects, self.lights, self.misses = np.zeros((3, generations, count), np.int64)
        self.belt = np.zeros(count, bool)
        world = self.renderer.world
        Wavefront(world, self._observe).trace(camera_rays(world, pixels, 1), count, max(count, 2), primary=False)

    def _observe(self, wave, interaction) -> None:
        slot, traced = wave.slot.numpy(), wave.weight.numpy() > 0
        index, lights = interaction.hit.index.numpy().astype(np.int64), interaction.lights_reached.numpy().astype(np.int64)
        kind = 2 + (0 if wave.refracted is None else wave.refracted.numpy())  # reflection and refraction rays apart
        for sums, values in ((self.objects, kind * 1009**(1 + index % 5) + index), (self.lights, kind * (index + 7) * lights),
                             (self.misses, kind * (index == len(self.scene.objects)))):
            np.add.at(sums[wave.generation], slot[traced], np.broadcast_to(values, slot.shape)[traced])
        if wave.generation == 0:
            point = interaction.point.numpy()
            for k, obj in enumerate(self.scene.objects):
                if obj.surface.type == "heart":
                    on = traced & (index == k) & (np.abs(point[1] - obj.surface.center[1]) < BELT)
                    self.belt[slot[on]] = True
