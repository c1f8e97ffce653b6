"""What the tests of reference_tracer share: small scenes in one line, and rays shot at them one by one."""

from __future__ import annotations

import json
from dataclasses import dataclass

import numpy as np

from raytruth.reference_tracer.backend import backend
from raytruth.reference_tracer.scene.load import parse_scene
from raytruth.reference_tracer.scene.model import Scene
from raytruth.reference_tracer.scene.placement import is_inside
from raytruth.reference_tracer.tracer.camera_rays import camera_wave
from raytruth.reference_tracer.tracer.rays import BITS, Ray, Sides
from raytruth.reference_tracer.tracer.wavefront import trace
from raytruth.reference_tracer.tracer.world import World


def thing(kind: str, center=(0, 0, 0), *, material: dict | None = None, rotation: dict | None = None,
          **surface) -> dict:
    """One object of a scene document."""
    document = {"surface": {"type": kind, "center": list(center), **surface}, "material": material or {}}
    return document | ({"rotation": rotation} if rotation else {})


def make_scene(*objects: dict, lights=(), size=(1, 1), camera: dict | None = None, background=(0, 0, 0),
               **tracing) -> Scene:
    """A scene through the parser, as a user's file would come. `lights` are (position, brightness) pairs.

    What tracing calls `lights` too is `lights_` here. A scene that names no light gets a black one: pictures without any are a case of their own (test_shading).
    """
    document = {
        "camera": {"width": size[0], "height": size[1], **(camera or {})},
        "objects": list(objects),
        "lights": [{"position": list(p), "brightness": list(b)} for p, b in lights or [((0, 0, 0), (0, 0, 0))]],
        "background": list(background),
        "tracing": {name.rstrip("_"): value for name, value in tracing.items()}}
    return parse_scene(json.dumps(document).encode(), "test scene")


@dataclass
class Found:
    """NumPy answers of `shoot`, one entry a ray."""

    t: np.ndarray
    index: np.ndarray  # -1 where nothing was hit
    undecided: np.ndarray
    order: np.ndarray


def shoot(scene: Scene, o, d, method: str = "exact", inside=None) -> Found:
    """The first hits of rays o + t d, (n, 3) each; `inside` (n, objects) are their sides, else the signs of f at o."""
    world, ray, count = _rays(scene, method, o, d, inside)
    hit = world.nearest(ray)
    wide = lambda array: np.broadcast_to(array.numpy(), count).copy()
    index = wide(hit.index).astype(int)
    met = index < world.object_count
    return Found(np.where(met, wide(hit.t), np.inf), np.where(met, index, -1), wide(hit.undecided), wide(hit.order))


def shine(scene: Scene, o, d, distance, method: str = "exact", inside=None) -> np.ndarray:
    """The part of a light's intensity that arrives at o from `distance` away in direction d."""
    world, ray, count = _rays(scene, method, o, d, inside)
    arrays = world.arrays
    intensity, _ = world.transmittance(ray, arrays.Float(np.broadcast_to(distance, count).astype(float).copy()),
                                       arrays.Bool(np.ones(count, bool)))
    return np.broadcast_to(intensity.numpy(), count).copy()


@dataclass
class Generation:
    """The rays of one generation, in the order of their pixels."""

    pixel: np.ndarray  # (n,)
    o: np.ndarray  # (n, 3)
    d: np.ndarray  # (n, 3)
    weight: np.ndarray  # (n,), share in the pixel's colour


def follow(scene: Scene, method: str = "exact") -> list[Generation]:
    """All rays that the picture of `scene` takes, generation by generation, the camera's rays first."""
    world = World(scene, method, backend())
    waves = []
    pixels = scene.camera.width * scene.camera.height
    trace(world, camera_wave(world, world.camera_sides(), 0, pixels, 1), slots=max(pixels, 2),
          observe=lambda wave, _: waves.append((wave.generation, wave.slot.numpy(), wave.ray.o.numpy().T,
                                                wave.ray.d.numpy().T, wave.weight.numpy())))
    generations = []
    for k in range(1 + max(wave[0] for wave in waves)):
        slot, o, d, weight = (np.concatenate(column) for column in zip(*(w[1:] for w in waves if w[0] == k)))
        order = np.argsort(slot, kind="stable")
        order = order[weight[order] > 0]  # without the padding of queues
        generations.append(Generation(slot[order], o[order], d[order], weight[order]))
    return generations


def _rays(scene, method, o, d, inside):
    arrays = backend()
    o, d = np.broadcast_arrays(np.atleast_2d(np.asarray(o, float)), np.atleast_2d(np.asarray(d, float)))
    d = d / np.linalg.norm(d, axis=-1, keepdims=True)
    if inside is None:
        inside = [[is_inside(obj, point) for obj in scene.objects] for point in o]
    inside = np.broadcast_to(inside, (len(o), len(scene.objects)))
    words = []
    for start in range(0, len(scene.objects), BITS):
        bits = inside[:, start:start + BITS].astype(np.uint64)
        words.append(arrays.Bits((bits << np.arange(bits.shape[1], dtype=np.uint64)).sum(axis=1, dtype=np.uint64)))
    vector = lambda v: arrays.Vector(*(arrays.Float(v[:, k].copy()) for k in range(3)))
    return World(scene, method, arrays), Ray(vector(o), vector(d), Sides(words)), len(o)


def unit(v) -> np.ndarray:
    v = np.asarray(v, float)
    return v / np.linalg.norm(v, axis=-1, keepdims=True)


def random_rays(count: int, seed: int, distance: float = 6.0, spread: float = 2.0):
    """Rays from a sphere of radius `distance` towards points near the origin: (o, d), (count, 3) each."""
    random = np.random.default_rng(seed)
    o = distance * unit(random.normal(size=(count, 3)))
    return o, unit(random.uniform(-spread, spread, (count, 3)) - o)
