"""From a scene to a picture: bands of rows, n x n samples a pixel, all planes."""

from __future__ import annotations

import time
from collections import OrderedDict
from collections.abc import Callable, Hashable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any

import drjit as dr
import numpy as np

from ..backend import backend, recorded, use_threads
from ..scene.model import Scene
from .camera_rays import CameraRays, camera_rays
from .film import HIT as HIT
from .film import MISS as MISS
from .film import PLANES, PlaneBuffer, developed
from .film import UNDECIDED as UNDECIDED
from .interpreting import InterpretingWorld, worth_it
from .rays import Ray
from .shading import Interaction
from .wavefront import MOST_RAYS, Advance, Film, Primary, Recorder, Wave, Wavefront
from .world import World


class Watch:
    """Looks into a render: what it does by default is nothing. Slots of a wave count from the band's first pixel.

    One that is a `recorder` besides is asked by that (wavefront.Recorder), and not wave by wave.
    """

    recorder: Recorder | None = None

    def begin(self, world: World, first: int, count: int) -> None:
        """A band of pixels [first, first + count) in row order begins."""

    def disturb(self, wave: Wave) -> Ray:
        """The rays to trace in place of the wave's."""
        return wave.ray

    def observe(self, wave: Wave, interaction: Interaction) -> None:
        """What became of a wave."""

    def end(self) -> None:
        """The band is done."""


@dataclass(repr=False)
class Picture:
    """What a render returns. Planes are (height, width) or (height, width, 3) NumPy arrays, row 0 at the top.

    The geometry planes (t, position, normal, index, status) are those of the ray through the pixel's centre. A plane
    that was not asked for is None.
    """

    color: np.ndarray  # (h, w, 3) fp64, linear and unclamped (decision P1)
    t: np.ndarray  # (h, w) fp64, distance to the first hit, infinity where nothing was hit
    position: np.ndarray  # (h, w, 3) fp64, NaN where nothing was hit
    normal: np.ndarray  # (h, w, 3) fp64, unit, turned against the ray, NaN where nothing was hit
    index: np.ndarray  # (h, w) int32, object in scene order, -1 where nothing was hit
    depth: np.ndarray  # (h, w) uint8, highest generation of secondary rays traced for the pixel
    status: np.ndarray  # (h, w) uint8, MISS, HIT, or UNDECIDED if any ray of the pixel was
    scene: Scene
    metadata: dict[str, Any] = field(default_factory=dict)

    def __repr__(self) -> str:
        camera, made = self.scene.camera, self.metadata.get("renderer") or self.metadata.get("method") or "unknown"
        return f"<Picture of {self.scene.name}, {camera.width} x {camera.height}, by {made}>"

    def _repr_png_(self) -> bytes | None:
        """How a notebook shows the picture: its colours as `save` writes them (decision P1)."""
        from .image_files import png

        return None if self.color is None else png(self.color)


def render(scene: Scene, method: str = "exact", *, precision: int | None = None, device: str = "llvm",
           threads: int | None = None, planes: Sequence[str] = PLANES, progress: Callable[[float], None] | None = None,
           watch: Watch | None = None, interpret: bool | None = None) -> Picture:
    """Renders `scene` with a first-hit method ("paper", "exact", ...); see `Renderer` for rendering it again.

    `precision` 64 or 32 stands in for the scene's own, `planes` are those wanted. `progress` is called with the
    finished fraction after every wave of rays; `watch` sees, and may disturb, every wave of rays. `interpret` tells whether
    formulas are interpreted, by kernels that they share, or compiled; None: as interpreting.worth_it has it. Raises InputError
    for an unknown method or an unusable device.
    """
    start = time.perf_counter()
    picture = Renderer(scene, method, precision=precision, device=device, threads=threads, interpret=interpret).picture(
        planes, progress, watch)
    picture.metadata["seconds"] = time.perf_counter() - start
    return picture


class Recordings:
    """What is recorded in one world for its pictures, and replayed in others whose kernels are the same."""

    def __init__(self, world: World):
        self.wavefront = Wavefront(world)
        self.first_hits, self.developed = recorded(self._first_hit), recorded(developed)

    def _first_hit(self, source: CameraRays, variables) -> Primary:
        world = self.wavefront.world
        ray = source.wave(world, 0).ray
        hit = world.nearest(ray)
        met = hit.index < world.object_count
        point = dr.fma(ray.d, dr.select(met, hit.t, 0), ray.o)
        normal = world.normal(point, hit.index, met)
        return Primary.of(world, hit, point, dr.select(dr.dot(ray.d, normal) > 0, -normal, normal))


MOST_SHARED = 8
_shared: OrderedDict[Hashable, Recordings] = OrderedDict()


def _shared_recordings(world: InterpretingWorld) -> Recordings:
    """The recordings of worlds of the same structure, most recently used last."""
    found = _shared[world.structure] = _shared.pop(world.structure, None) or Recordings(world)
    while len(_shared) > MOST_SHARED:
        _shared.popitem(last=False)
    return found


class Renderer:
    """A scene made ready for rendering: what is recorded for one picture is replayed for the next.

    `world` may be a tracer that differs in a query or a formula, for showing what a fault does; `interpret` as in `render`.
    Raises InputError for an unknown method or an unusable device.
    """

    def __init__(self, scene: Scene, method: str = "exact", *, precision: int | None = None, device: str = "llvm",
                 threads: int | None = None, world: type[World] = World, interpret: bool | None = None):
        self.precision = precision or scene.tracing.precision
        self.scene, self.method, self.device = scene, method, device
        if interpret is None:
            interpret = world is World and (self.precision, device) == (64, "llvm") and worth_it(scene, method)
        self.world = (InterpretingWorld if interpret else world)(scene, method, backend(self.precision, device))
        self.threads = use_threads(threads)
        self.recordings = _shared_recordings(self.world) if interpret else Recordings(self.world)
        self._watched: dict[int, Wavefront] = {}  # of recorders

    def show(self, scene: Scene, world: type[World] = World) -> None:
        """Goes on with a `scene` that differs from the one before in places alone: what is recorded is replayed with them."""
        self.scene, self.world = scene, world(scene, self.method, backend(self.precision, self.device))
        for wavefront in self._watched.values():
            wavefront.world = self.world

    def picture(self, planes: Sequence[str] = PLANES, progress: Callable[[float], None] | None = None,
                watch: Watch | None = None, band: int | None = None) -> Picture:
        """The picture, with the wanted `planes` only; see `render`. A band has at most `band` camera rays, or MOST_RAYS."""
        start = time.perf_counter()
        camera, tracing = self.scene.camera, self.scene.tracing
        adaptive = tracing.samples > 1 and tracing.adaptive > 0
        film = PlaneBuffer((*planes, "color", "index") if adaptive else planes, camera.height, camera.width)
        self.recordings.wavefront.world = self.world  # another renderer, or `show`, may have left it in another one
        wavefront = self._wavefront(watch)
        before, centres = wavefront.rays, 0
        first = 0.5 if adaptive else 1.0  # the share of the first pass over the pixels
        for pixels in self.bands(1 if adaptive else tracing.samples, band):
            if watch:
                watch.begin(self.world, pixels.start, len(pixels))
            centres += self._render(wavefront, pixels, 1 if adaptive else tracing.samples, film,
                                    _within(progress, first * pixels.start / len(film), first * pixels.stop / len(film)))
            if watch:
                watch.end()
        if adaptive:
            self._resample(film, wavefront, band, progress and (lambda share: progress(first + (1 - first) * share)))
        if progress:
            progress(1.0)
        picture = Picture(scene=self.scene, **film.planes(planes))
        picture.metadata = {
            "scene": self.scene.name, "scene_hash": self.scene.hash, "method": self.method,
            "precision": self.precision, "device": self.device, "threads": self.threads,
            "rays": wavefront.rays - before + centres, "seconds": time.perf_counter() - start, "drjit": dr.__version__}
        return picture

    @property
    def wavefront(self) -> Wavefront:
        self.recordings.wavefront.world = self.world
        return self.recordings.wavefront

    def _wavefront(self, watch: Watch | None) -> Wavefront:
        if watch is None:
            return self.wavefront
        if watch.recorder is None:
            return Wavefront(self.world, watch.observe, watch.disturb)
        return self._watched.setdefault(id(watch.recorder), Wavefront(self.world, recorder=watch.recorder))

    def follow(self, pixels: Sequence[int], watch: Watch) -> None:
        """Traces the rays of `pixels`, numbers in row order, and no others; slots count them. `watch` sees every wave."""
        samples = self.scene.tracing.samples
        watch.begin(self.world, 0, len(pixels))
        Wavefront(self.world, watch.observe, watch.disturb).trace(
            camera_rays(self.world, np.asarray(pixels), samples), len(pixels) * samples**2, max(len(pixels), 2), primary=False)
        watch.end()

    def bands(self, samples: int, rays: int | None = None) -> Iterator[range]:
        """Pixels in row order, as many at a time as `rays` leave room for; whole rows if a row fits."""
        camera = self.scene.camera
        pixels, most = camera.width * camera.height, max(1, (rays or MOST_RAYS) // samples**2)
        if most > camera.width:
            most -= most % camera.width
        for first in range(0, pixels, most):
            yield range(first, min(first + most, pixels))

    def _render(self, wavefront: Wavefront, pixels: range, samples: int, film: PlaneBuffer,
                progress: Callable[[Advance], None] | None) -> int:
        """Renders `pixels` into `film`; returns the number of rays beyond those that the wavefront counts."""
        source, count = camera_rays(self.world, pixels, samples), len(pixels)
        primary = film.wants_hits and samples == 1
        light, hits = wavefront.trace(source, count * samples**2, max(count, 2), primary, progress)
        centres = film.wants_hits and samples > 1  # the geometry planes belong to the pixel's centre
        if centres:
            hits = self.recordings.first_hits(camera_rays(self.world, pixels, 1), self.world.variables)
        film.store(slice(pixels.start, pixels.stop), self.developed(light, hits, samples))
        return count if centres else 0

    def developed(self, light: Film, hits: Primary | None, samples: int) -> dict:
        """The planes of pixels of n x n samples; see `film.developed`."""
        world = self.world
        per_unit = dr.opaque(dr.float64_array_t(world.arrays.Float), world.optics.samples(samples) / world.color_unit)
        return self.recordings.developed(light, hits, per_unit, world.arrays.count(world.object_count))

    def _resample(self, film: PlaneBuffer, wavefront: Wavefront, band: int | None,
                  progress: Callable[[float], None] | None) -> None:
        """Takes n x n samples of the pixels that differ from a neighbour (`adaptive` of the scene)."""
        samples = self.scene.tracing.samples
        chosen = np.flatnonzero(differing(film["color"], film["index"], self.scene.tracing.adaptive))
        most = max(1, (band or MOST_RAYS) // samples**2)
        for start in range(0, len(chosen), most):
            pixels = chosen[start:start + most]
            light, _ = wavefront.trace(camera_rays(self.world, pixels, samples), len(pixels) * samples**2,
                                       max(len(pixels), 2), primary=False, progress=_within(
                                           progress, start / len(chosen), (start + len(pixels)) / len(chosen)))
            seen = self.developed(light, None, samples)
            film.store(pixels, seen)
            film.mark_undecided(pixels, seen)


def _within(progress: Callable[[float], None] | None, start: float, stop: float) -> Callable[[Advance], None] | None:
    """Tells `progress` how far the picture is while its part from `start` to `stop` is traced."""
    return progress and (lambda advance: progress(start + (stop - start) * advance.share))


def differing(color: np.ndarray, index: np.ndarray, threshold: float) -> np.ndarray:
    """Section 5, no more than needed: pixels that differ from one of their eight neighbours, in the object seen or in a
    channel by more than `threshold`. (h, w) bool, from the colours (h, w, 3) and objects (h, w) seen through the pixels'
    centres."""
    height, width = index.shape
    found = np.zeros((height, width), bool)
    for down, right in ((0, 1), (1, 0), (1, 1), (1, -1)):  # the other four are the same pairs seen from the other side
        here = slice(0, height - down), slice(max(0, -right), width - max(0, right))
        there = slice(down, height), slice(max(0, right), width - max(0, -right))
        apart = (index[here] != index[there]) | ~(np.abs(color[here] - color[there]).max(axis=-1) <= threshold)
        found[here] |= apart
        found[there] |= apart
    return found
