"""What a render will take, told before it: rays, seconds, memory.

The number of camera rays is known and an upper bound of all rays follows from materials and depth. How many there will
be, and how long they take, is measured: the same kernels trace some of the picture's pixels. Where each ray has b
secondary ones in the mean of a generation, the next one has b times as many; the product over the generations is the
size of the tree of rays (Knuth, Estimating the efficiency of backtrack programs, 1975), so that a trial that was ended
early estimates it too.
"""

from __future__ import annotations

import math
import os
import resource
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ..scene.model import Scene
from .camera_rays import camera_rays
from .film import TYPES, VECTORS
from .render import Renderer
from .wavefront import MOST_HELD, MOST_RAYS, Advance, row_bytes

FEWEST = 16  # rays of the first trial
PLACES = 8  # of the picture that each trial looks at
SPREAD = 1.5  # a range is as much wider than what was seen: other work slows a machine down, caches warm up
PATIENCE = 3.0  # seconds for all trials together, without compilation
BAND = 2.0  # seconds that a band of rays should take, so that progress is seen and an interrupt is heard
SHORTEST_BAND = 1 << 10  # rays

STARTED = 400 << 20  # bytes of the process with its libraries and a small kernel
WAVE_ROW = 300  # bytes of intermediate results a ray of the wave that is traced
CHARACTER = 130_000  # bytes that a character of a formula takes in the compiler


@dataclass(frozen=True)
class Estimate:
    """What is expected of a render; ranges are (low, high)."""

    camera_rays: int
    most_rays: float  # an upper bound of all rays
    rays: tuple[float, float]
    seconds: tuple[float, float]
    band: int  # camera rays to trace at a time

    @property
    def sentence(self) -> str:
        """In words."""
        secondary = [max(rays - self.camera_rays, 0) for rays in self.rays]
        others = f" and {_about(*secondary, _count)} secondary rays (at most {_count(self.most_rays - self.camera_rays)})" \
            if self.most_rays > self.camera_rays else ""
        return f"{self.camera_rays:,} camera rays{others} will take {_about(*self.seconds, duration)}"


def camera_ray_count(scene: Scene) -> int:
    """The camera rays of a picture without adaptive sampling."""
    return scene.camera.width * scene.camera.height * scene.tracing.samples**2


def most_rays(scene: Scene) -> float:
    """An upper bound of the rays of a picture, shadow rays not counted: every ray hits, and every hit answers in full."""
    effects, materials = scene.tracing.effects, [o.material for o in scene.objects]
    reflects = [("reflection" in effects and m.reflection > 0) + ("refraction" in effects and m.transparency > 0)
                for m in materials]
    branching, depth = max(reflects), scene.tracing.max_depth
    return float(camera_ray_count(scene)) * sum(float(branching)**k for k in range(depth + 1))


def memory(scene: Scene, planes: Sequence[str], copies: int = 0) -> int:
    """The bytes that a render takes at its worst; `copies` are those a pixel takes beside its planes, e.g. in writing."""
    pixels, rays = scene.camera.width * scene.camera.height, camera_ray_count(scene)
    plane = sum(np.dtype(TYPES[name]).itemsize * (3 if name in VECTORS else 1) for name in planes)
    wave, row = min(MOST_RAYS, most_rays(scene)), row_bytes(scene)
    waiting = min(MOST_HELD, row * most_rays(scene)) if most_rays(scene) > rays else 0
    formulas = {o.surface.family: len(getattr(o.surface, "formula", "")) for o in scene.objects}
    return int(STARTED + pixels * (plane + copies) + wave * (WAVE_ROW + row) + waiting + CHARACTER * sum(formulas.values()))


def available() -> int:
    """The bytes of memory that this process may still take: what the machine has left, and its limits."""
    found = [os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")]
    for line in _lines("/proc/meminfo"):
        if line.startswith("MemAvailable:"):
            found.append(int(line.split()[1]) << 10)
    for most, used in (("memory.max", "memory.current"), ("memory/memory.limit_in_bytes", "memory/memory.usage_in_bytes")):
        values = [line.strip() for name in (most, used) for line in _lines(f"/sys/fs/cgroup/{name}")]
        if len(values) == 2 and all(value.isdigit() for value in values):
            found.append(int(values[0]) - int(values[1]))
    for limit in (resource.RLIMIT_AS, resource.RLIMIT_DATA):
        soft = resource.getrlimit(limit)[0]
        if soft != resource.RLIM_INFINITY:
            found.append(soft)
    return max(min(found), 0)


def _lines(path: str) -> list[str]:
    try:
        return Path(path).read_text().splitlines()
    except OSError:
        return []


class _Enough(Exception):
    """A trial has lasted long enough."""


class _Trial:
    """Counts the rays of each generation while some pixels are traced; ends after `deadline`.

    One `to_the_end` ends a path first: every kernel has been compiled by then.
    """

    def __init__(self, deadline: float, generations: int, to_the_end: bool):
        self.deadline, self.deepest = deadline, not to_the_end
        self.rays, self.secondary = [0] * generations, [0] * generations

    def __call__(self, advance: Advance) -> None:
        self.rays[advance.generation] += advance.rays
        self.secondary[advance.generation] += advance.secondary
        self.deepest |= advance.secondary == 0
        if self.deepest and time.perf_counter() > self.deadline:
            raise _Enough

    @property
    def per_camera_ray(self) -> float:
        """All rays of a camera ray's tree, itself included; a generation not reached is taken to be like the one before."""
        total, generation, branching = 1.0, 1.0, 0.0
        for rays, secondary in zip(self.rays, self.secondary):
            branching = secondary / rays if rays else branching
            generation *= branching
            total += generation
        return total


def estimate(renderer: Renderer, told: Callable[[str], None] = lambda stage: None) -> Estimate:
    """Measures what `renderer`'s picture will take; compiles its kernels on the way. `told` hears what is being done."""
    scene, samples = renderer.scene, renderer.scene.tracing.samples
    pixels, camera, most = scene.camera.width * scene.camera.height, camera_ray_count(scene), most_rays(scene)
    random = np.random.default_rng(0)
    told("compiling kernels")
    _run(renderer, 0, FEWEST, samples, patience=0.0)
    told("measuring")
    trials, count, spent = [], FEWEST, 0.0
    while spent < 0.7 * PATIENCE:
        runs = [_run(renderer, int((k + random.random()) * max(pixels - count, 0) / PLACES), count, samples,
                     max(PATIENCE - spent, 0.1 * PATIENCE) / PLACES) for k in range(PLACES)]
        seconds = sum(run_seconds for _, run_seconds in runs)
        spent += seconds
        rays = sum(sum(trial.rays) for trial, _ in runs)
        trials.append((count, float(np.mean([trial.per_camera_ray for trial, _ in runs])), seconds / rays))
        if PLACES * count >= pixels:
            break
        growth = min(8.0, 0.3 * PATIENCE / max(seconds, 1e-4))
        count = max(1, int(min(max(count * growth, FEWEST), pixels, MOST_RAYS / samples**2)))
    cost = trials[-1][2]
    trees = [tree for pixels_seen, tree, _ in trials if pixels_seen >= count / 8]  # smaller ones have seen too little
    low, high = camera * min(trees), min(camera * max(trees), most)
    likely = float(np.mean(trees))
    band = int(min(MOST_RAYS, max(SHORTEST_BAND, BAND / (cost * likely))))
    return Estimate(camera, most, (min(low, high), high), (low * cost / SPREAD, SPREAD * high * cost), band)


def _run(renderer: Renderer, first: int, count: int, samples: int, patience: float) -> tuple[_Trial, float]:
    """Traces `count` pixels from `first` on for about `patience` seconds; for 0 until every kernel has been compiled."""
    count = max(1, min(count, renderer.scene.camera.width * renderer.scene.camera.height - first))
    start = time.perf_counter()
    trial = _Trial(start + patience, renderer.scene.tracing.max_depth + 1, to_the_end=patience == 0)
    try:
        light, _ = renderer.wavefront.trace(camera_rays(renderer.world, range(first, first + count), samples),
                                            count * samples**2, max(count, 2), progress=trial)
        light.color.numpy()  # waits for the kernels
    except _Enough:
        pass
    return trial, time.perf_counter() - start


# --- in words ------------------------------------------------------------------------------------------------------
def _about(low: float, high: float, text: Callable[[float], str]) -> str:
    return f"about {text(high)}" if text(low) == text(high) else f"{text(low)} to {text(high)}"


def _count(value: float) -> str:
    if value < 1e6:
        return f"{value:,.0f}"
    return f"{value / 1e6:,.3g} million" if value < 1e9 else f"{value:.1e}"


def duration(seconds: float) -> str:
    """A time in words, as exact as an estimate deserves."""
    for unit, name in ((365.25 * 86400, "years"), (86400, "days"), (3600, "hours"), (60, "minutes")):
        if seconds >= 2 * unit:
            value = seconds / unit
            return f"{value:.1e} {name}" if value >= 1e4 else f"{value:.0f} {name}"
    return f"{math.ceil(seconds)} s"


def size_of(amount: float) -> str:
    """Bytes in words."""
    return f"{amount / (1 << 30):.1f} GiB"
