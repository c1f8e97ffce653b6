"""From a scene to a picture: bands of rows, n x n samples a pixel, all planes."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, field

import drjit as dr
import numpy as np

from .backend import Backend, backend, use_threads
from .camera import canvas_point, frame
from .rays import Ray, Sides
from .scene.model import Scene
from .shading import Collision
from .wavefront import MOST_RAYS, Film, Primary, Wave, trace
from .world import World

MISS, HIT, UNDECIDED = 0, 1, 2  # of the status plane


class Watch:
    """Looks into a render: what it does by default is nothing. Slots of a wave count from the band's first pixel."""

    def begin(self, world: World, first: int, count: int) -> None:
        """A band of pixels [first, first + count) in row order begins."""

    def disturb(self, wave: Wave) -> Ray:
        """The rays to trace in place of the wave's."""
        return wave.ray

    def observe(self, wave: Wave, collision: Collision) -> None:
        """What became of a wave."""

    def end(self) -> None:
        """The band is done."""


@dataclass
class Picture:
    """What a render returns. Planes are (height, width) or (height, width, 3) NumPy arrays, row 0 at the top.

    The geometry planes (t, position, normal, index, status) are those of the ray through the pixel's centre.
    """

    color: np.ndarray  # (h, w, 3) fp64, linear and unclamped (decision P1)
    t: np.ndarray  # (h, w) fp64, distance to the first hit, infinity where nothing was hit
    position: np.ndarray  # (h, w, 3) fp64, NaN where nothing was hit
    normal: np.ndarray  # (h, w, 3) fp64, unit, turned against the ray, NaN where nothing was hit
    index: np.ndarray  # (h, w) int32, object in scene order, -1 where nothing was hit
    depth: np.ndarray  # (h, w) uint8, highest generation of secondary rays traced for the pixel
    status: np.ndarray  # (h, w) uint8, MISS, HIT, or UNDECIDED if any ray of the pixel was
    scene: Scene
    metadata: dict = field(default_factory=dict)


def render(scene: Scene, method: str = "exact", *, precision: int = 64, device: str = "llvm",
           threads: int | None = None, progress: Callable[[float], None] | None = None,
           watch: Watch | None = None) -> Picture:
    """Renders `scene` with a first-hit method ("paper", "exact", ...).

    `progress` is called with the finished fraction after every band; `watch` sees, and may disturb, every wave of
    rays. Raises InputError for an unknown method or an unusable device.
    """
    arrays = backend(precision, device)
    used_threads = use_threads(threads)
    start = time.perf_counter()
    world = World(scene, method, arrays)
    sides = world.camera_sides()
    width, height, samples = scene.camera.width, scene.camera.height, scene.tracing.samples
    pixels = width * height
    planes = _empty_planes(pixels)
    band = max(1, MOST_RAYS // samples**2)
    if band > width:
        band -= band % width  # whole rows
    rays = 0
    for first in range(0, pixels, band):
        count = min(band, pixels - first)
        rays += _render_band(world, sides, first, count, samples, planes, watch)
        if progress:
            progress((first + count) / pixels)
    picture = Picture(scene=scene, **{name: plane.reshape(height, width, *plane.shape[1:])
                                      for name, plane in planes.items()})
    picture.metadata = {"scene": scene.name, "scene_hash": scene.hash, "method": method, "precision": precision,
                        "device": device, "threads": used_threads, "rays": rays,
                        "seconds": time.perf_counter() - start, "drjit": dr.__version__}
    return picture


def _empty_planes(pixels: int) -> dict[str, np.ndarray]:
    return {"color": np.empty((pixels, 3)), "t": np.empty(pixels), "position": np.empty((pixels, 3)),
            "normal": np.empty((pixels, 3)), "index": np.empty(pixels, np.int32),
            "depth": np.empty(pixels, np.uint8), "status": np.empty(pixels, np.uint8)}


def _render_band(world: World, sides: Sides, first: int, count: int, samples: int, planes, watch: Watch | None) -> int:
    """Renders pixels [first, first + count) in row order into `planes`; returns the number of rays traced."""
    per_pixel = samples * samples
    wave = camera_wave(world, sides, first, count, samples)
    if watch:
        watch.begin(world, first, count)
        film, primary = trace(world, wave, max(count, 2), watch.observe, watch.disturb)
        watch.end()
    else:
        film, primary = trace(world, wave, max(count, 2))
    rays = film.rays
    if samples > 1:  # the geometry planes belong to the pixel's centre
        centres = camera_wave(world, sides, first, count, 1)
        primary = _primary_only(world, centres)
        rays += len(centres)
    _store(film, primary, world.object_count, per_pixel, slice(first, first + count), planes)
    return rays


def _primary_only(world: World, wave: Wave) -> Primary:
    hit = world.nearest(wave.ray)
    met = hit.index < world.object_count
    point = dr.fma(wave.ray.d, dr.select(met, hit.t, 0), wave.ray.o)
    normal = world.normal(point, hit.index, met)
    normal = dr.select(dr.dot(wave.ray.d, normal) > 0, -normal, normal)
    primary = Primary(dr.select(met, hit.t, dr.inf), point, normal, hit.index)
    dr.eval(primary)
    return primary


def camera_wave(world: World, sides: Sides, first: int, count: int, samples: int) -> Wave:
    """The camera rays of pixels [first, first + count) in row order, n x n a pixel (sections 2 and 5)."""
    arrays: Backend = world.arrays
    f = frame(world.scene.camera)
    per_pixel = samples * samples
    lane = dr.arange(arrays.UInt, max(count * per_pixel, 2))
    slot = dr.minimum(lane // per_pixel, arrays.count(count - 1))
    sample, pixel = lane % per_pixel, slot + arrays.count(first)
    width = arrays.count(f.width)
    x, y = canvas_point(f.mapped(arrays.constant), arrays.Float(pixel // width), arrays.Float(pixel % width),
                        arrays.Float(sample // samples), arrays.Float(sample % samples), samples)
    v_x, v_y, v_dir, v_pos = (arrays.vector(v.tolist()) for v in (f.v_x, f.v_y, f.v_dir, f.v_pos))
    d = dr.normalize(x * v_x + y * v_y + v_dir)
    o = v_pos + dr.zeros(arrays.Vector, dr.width(lane))
    every = Sides([word + dr.zeros(arrays.Bits, dr.width(lane)) for word in sides.words])
    # a band of one ray is padded with a second of weight 0, see wavefront
    weight = dr.select(lane < arrays.count(count * per_pixel), arrays.Float(1), 0)
    dr.eval(o, d, every.words, weight, slot)
    return Wave(0, Ray(o, d, every), weight, slot)


def _store(film: Film, primary: Primary, object_count: int, per_pixel: int, where: slice, planes):
    count = where.stop - where.start
    numpy = lambda array: array.numpy()[..., :count]
    met = numpy(primary.index) < object_count
    planes["color"][where] = numpy(film.color).T / per_pixel
    planes["t"][where] = numpy(primary.t)
    planes["position"][where] = np.where(met[:, None], numpy(primary.point).T, np.nan)
    planes["normal"][where] = np.where(met[:, None], numpy(primary.normal).T, np.nan)
    planes["index"][where] = np.where(met, numpy(primary.index), -1)
    planes["depth"][where] = numpy(film.generation)
    planes["status"][where] = np.where(numpy(film.undecided) > 0, UNDECIDED, np.where(met, HIT, MISS))
