"""What the child process does with one contestant: a first picture that is judged, and warm runs that are timed."""

from __future__ import annotations

import resource
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import drjit as dr
import numpy as np

from raytruth.reference_tracer.backend import recorded, use_threads
from raytruth.reference_tracer.errors import UnsupportedError
from raytruth.reference_tracer.first_hit import Intersection
from raytruth.reference_tracer.scene.model import Scene
from raytruth.reference_tracer.tracer.camera_rays import camera_rays
from raytruth.reference_tracer.tracer.render import Picture, Renderer
from raytruth.reference_tracer.tracer.world import World

from .. import renderers
from ..bench.timing import Cost, timed

SHORTEST = 0.03  # seconds: quicker runs are repeated until their times can be told from the clock's noise
LARGEST_STEP = 1000.0  # of the scene format


@dataclass
class Run:
    """A picture with its cost. `build` is in wall seconds, None where nothing is converted."""

    picture: Picture
    cost: Cost
    build: float | None = None
    program_kib: int = 0  # peak memory of programs that were run


class Competitor:
    """What is measured, bound to a scene."""

    def run(self, warm: bool = False) -> Run:
        """The picture that is judged; `warm`: once more, for its time."""
        raise NotImplementedError

    def first_hits(self) -> Cost | None:
        """The camera rays' first hits alone, warm; None where they cannot be had apart."""

    def evaluations(self) -> float | None:
        """Of f, a camera ray; None where they cannot be counted."""


def competitor(scene: Scene, renderer: str, settings: dict, timed_settings: dict, truth: Path | None,
               threads: int | None) -> Competitor:
    """Raises InputError for what is not known, UnsupportedError for what cannot do the scene."""
    if renderer != "reference":
        return Other(scene, renderer, settings, timed_settings)
    settings = dict(settings)
    method = settings.pop("method")
    if method == "oracle":
        return Oracle(scene, truth)
    if method == "descartes" and all(obj.surface.degree is None for obj in scene.objects):
        raise UnsupportedError("none of the surfaces is algebraic: Descartes' rule does not apply")
    if method == "crude":  # the sign of f at the ray's end, and nothing before it
        method, settings["step_size"] = "paper", min(scene.tracing.max_distance, LARGEST_STEP)
    return Ours(scene, method, threads=threads, **settings)


class Ours(Competitor):
    """A first-hit method of the reference tracer; what is recorded for the first picture is replayed for the others."""

    def __init__(self, scene: Scene, method: str, precision: int = 64, threads: int | None = None, **tracing):
        self.scene, self.method, self.threads = scene.traced_with(**tracing), method, threads
        self.renderer = Renderer(self.scene, method, precision=precision, threads=threads)
        self.world = self.renderer.world
        self._find = recorded(self._nearest)
        self._rays = None

    def run(self, warm: bool = False) -> Run:
        use_threads(self.threads)
        pictures = []
        cost = (repeatedly if warm else timed)(lambda: pictures.append(self.renderer.picture()))
        return Run(pictures[-1], cost)

    def first_hits(self) -> Cost:
        use_threads(self.threads)
        if self._rays is None:
            camera = self.scene.camera
            self._rays = camera_rays(self.world, range(camera.width * camera.height), 1)
            self._hits()
        return repeatedly(self._hits)

    def _hits(self) -> None:
        dr.eval(self._find(self._rays, self.world.variables))
        dr.sync_thread()

    def _nearest(self, rays, variables):
        hit = self.world.nearest(rays.wave(self.world, 0).ray)
        return hit.t, hit.index, hit.undecided

    def evaluations(self) -> float:
        """Counted in a world of its own, so that counting costs the timed one nothing."""
        world = World(self.scene, self.method, self.world.arrays)
        counter = dr.zeros(world.arrays.Bits, 1)
        dr.make_opaque(counter)
        for family in world.families:
            family.method = Counted(family.method, counter)
        pixels = self.scene.camera.width * self.scene.camera.height
        hit = world.nearest(camera_rays(world, range(pixels), 1).wave(world, 0).ray)
        dr.eval(hit.t, hit.index, counter)
        return counter[0] / pixels


class Counted:
    """A first-hit method that adds up its own evaluations of f."""

    def __init__(self, base, counter):
        self.base, self.counter = base, counter
        self.name, self.variables = base.name, base.variables
        self.vouches, self.closed_form = base.vouches, base.closed_form

    def first(self, solid, ray, inside, limit) -> Intersection:
        crossing = self.base.first(solid, ray, inside, limit)
        # a number that is the same for all rays is one number: the condition, true of every ray, makes one a ray of it
        each = dr.select(dr.abs(ray.d[0]) < 2, type(self.counter)(crossing.evaluations), 0)
        dr.scatter_add(self.counter, each, dr.uint32_array_t(self.counter)(0))
        return crossing

    def crossings(self, *arguments):
        return self.base.crossings(*arguments)


class Other(Competitor):
    """Another renderer: built and traced anew every time, each apart."""

    def __init__(self, scene: Scene, name: str, settings: dict, timed_settings: dict):
        self.scene, self.name, self.settings, self.timed_settings = scene, name, settings, timed_settings

    def run(self, warm: bool = False) -> Run:
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        picture = renderers.render(self.name, self.scene, {**self.settings, **(self.timed_settings if warm else {})})
        after, facts = resource.getrusage(resource.RUSAGE_CHILDREN), picture.metadata
        # a program's processor time is what the system says of it, starting included, a picture at a time
        program = (after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime) / facts.get("pictures", 1)
        return Run(picture, Cost(facts["first"], program or facts["cpu"]), facts.get("build"), after.ru_maxrss)


class Oracle(Competitor):
    """Hands the truth through: the least that a picture can cost, and an accuracy that must come out perfect."""

    def __init__(self, scene: Scene, truth: Path):
        with np.load(truth) as file:
            self.planes = {name: file[name] for name in ("color", "t", "index")}
        self.scene = scene

    def run(self, warm: bool = False) -> Run:
        copies = []
        copy = lambda: copies.append({name: plane.copy() for name, plane in self.planes.items()})
        cost = (repeatedly if warm else timed)(copy)
        color, index = copies[-1]["color"], copies[-1]["index"]
        unknown = np.full(color.shape, np.nan)
        return Run(Picture(**copies[-1], position=unknown, normal=unknown, depth=np.zeros(index.shape, np.uint8),
                           status=(index >= 0).astype(np.uint8), scene=self.scene), cost)


def repeatedly(work: Callable[[], object]) -> Cost:
    """The cost of `work`, in the mean over as many runs as it takes to measure it."""
    total, runs = Cost(0.0, 0.0), 0
    while total.wall < SHORTEST:
        one = timed(work)
        total, runs = Cost(total.wall + one.wall, total.cpu + one.cpu), runs + 1
    return Cost(total.wall / runs, total.cpu / runs)
