"""The state of a search: the truth, the scene planned so far, and trials of what else it could do without."""

from __future__ import annotations

import time
from collections.abc import Callable, Collection
from dataclasses import dataclass, field

import numpy as np

from raytruth.reference_tracer.scene.model import Scene
from raytruth.reference_tracer.tracer.render import Renderer, Watch, render
from raytruth.reference_tracer.tracer.sensitivity import sensitivity

from ..bench.timing import timed
from .document import DecisionRecord, Trial

COLOUR = ("color",)  # the plane that a tolerance is about
MOST_EXCUSED = 1e-3  # share of the pixels; if rounding decides more of them, it is no excuse but a reason for fp64
Change = Callable[[Scene], Scene]
TURNS = 5
GLANCE, LEAST_GLANCE = 4, 48  # how much smaller the picture of a first glance is; pixels of its shorter side
OBVIOUS = 0.01  # share of its pixels: far more than rounding may excuse


def deciding(scene_hash: str, height: int, width: int, attempt: int = 1) -> np.ndarray:
    """(height, width) bool: a random half of the pixels, the same whenever the same scene is planned.

    These decide; the others are held back, to check the decisions on.
    """
    random = np.random.default_rng([int(scene_hash[:16], 16), attempt])
    chosen = np.zeros(height * width, bool)
    chosen[random.permutation(height * width)[:(height * width + 1) // 2]] = True
    return chosen.reshape(height, width)


def truth_of(scene: Scene) -> Scene:
    """`scene` with exact intersections in double precision, whatever it says of its own."""
    objects = tuple(o.model_copy(update={"first_hit": None}) for o in scene.objects)
    return scene.model_copy(update={"objects": objects}).traced_with(precision=64)


@dataclass(frozen=True)
class Difference:
    """How far a picture is from the truth on some pixels."""

    largest: float  # of any channel; of pixels that are not excused
    excused: int
    excused_largest: float
    over: int  # pixels beyond the limit that are not excused


class Yardstick:
    """The scene as written with exact intersections, and how far other pictures of it are away, at the size of `scene`."""

    def __init__(self, scene: Scene, tolerance: float):
        self.scene, self.tolerance = truth_of(scene), tolerance
        self.color = render(self.scene, "exact", planes=COLOUR).color
        self._bounds: dict[int, np.ndarray] = {}

    def change(self, candidate: Scene) -> np.ndarray:
        """(h, w): the largest change of a channel of every pixel in `candidate`; infinite where it is not finite."""
        return self.from_truth(render(candidate, "exact", planes=COLOUR).color)

    def from_truth(self, color: np.ndarray) -> np.ndarray:
        change = np.abs(color - self.color).max(axis=-1)
        return np.where(np.isfinite(change), change, np.inf)

    def difference(self, change: np.ndarray, pixels: np.ndarray, precision: int,
                   limit: float | None = None) -> Difference:
        """What counts of `change` on `pixels` (h, w, bool), for a picture computed in `precision` bits.

        A pixel over `limit` (default: the tolerance) is excused if rounding to that precision alone may change it as
        much; the map that says so is measured only if few enough pixels ask for it.
        """
        over = (change > (self.tolerance if limit is None else limit)) & pixels
        excused = np.zeros_like(over)
        if 0 < over.sum() <= self.most_excused(pixels):
            excused = over & (change <= self._bound(precision))
        rest = change[pixels & ~excused]
        return Difference(float(rest.max(initial=0.0)), int(excused.sum()), float(change[excused].max(initial=0.0)),
                          int((over & ~excused).sum()))

    @staticmethod
    def most_excused(pixels: np.ndarray) -> int:
        return int(MOST_EXCUSED * pixels.sum())

    def _bound(self, precision: int) -> np.ndarray:
        if precision not in self._bounds:
            self._bounds[precision] = sensitivity(self.scene, "exact", precision).bound
        return self._bounds[precision]


class RayStatistics(Watch):
    """Notes what every ray of some pixels (h, w, bool) meets."""

    def __init__(self, scene: Scene, pixels: np.ndarray):
        self.pixels = pixels.ravel()
        self.objects = np.zeros(len(scene.objects) + 1, bool)
        self.farthest = 0.0
        self.generations = 0
        render(scene, "exact", watch=self)

    def begin(self, world, first, count):
        self.first = first

    def observe(self, wave, interaction):
        slot = wave.slot.numpy().astype(np.int64) + self.first
        counts = (wave.weight.numpy() > 0) & self.pixels[np.minimum(slot, len(self.pixels) - 1)]
        index = interaction.hit.index.numpy()[counts]
        if not index.size:
            return
        self.objects |= np.bincount(index, minlength=len(self.objects)) > 0
        self.generations = max(self.generations, wave.generation)
        hit = index < len(self.objects) - 1
        self.farthest = max(self.farthest, float(interaction.hit.t.numpy()[counts][hit].max(initial=0.0)))

    def met(self, k: int) -> bool:
        """Whether any ray hits object `k`."""
        return bool(self.objects[k])


@dataclass
class Decision:
    """One decision: what it does to a scene (None: nothing), and what is told of it."""

    parameter: str
    written: str
    planned: str
    evidence: str
    change: Change | None = None
    trials: list[Trial] = field(default_factory=list)
    withdrawn: bool = False

    def record(self) -> DecisionRecord:
        in_force = self.change is not None and not self.withdrawn
        return DecisionRecord(parameter=self.parameter, written=self.written,
                              planned=self.planned if in_force else self.written, changed=in_force,
                              withdrawn=self.withdrawn, evidence=self.evidence, trials=self.trials)


class OutOfTime(Exception):
    """The search has used its time: what is decided stands, the rest stays as written."""


class Search:
    """`scene` is what is planned so far, at the size of the search; `written` the scene it began with."""

    def __init__(self, yardstick: Yardstick, written: Scene, pixels: np.ndarray, limit: float, deadline: float):
        """`pixels` (h, w, bool) decide; they may change by `limit`; `deadline` is a time.monotonic()."""
        self.yardstick, self.written, self.scene = yardstick, written, written
        self.pixels, self.limit, self.deadline = pixels, limit, deadline
        self.rays = RayStatistics(yardstick.scene, pixels)
        camera = written.camera
        small = (camera.width // GLANCE, camera.height // GLANCE)
        self._glance = Yardstick(written.resized(*small), yardstick.tolerance) if min(small) >= LEAST_GLANCE else None
        self._trials: list[Trial] = []

    def holds(self, value: str, change: Change) -> bool:
        """Tries `change` on top of what is planned so far. Raises OutOfTime."""
        if time.monotonic() > self.deadline:
            raise OutOfTime
        candidate = change(self.scene)
        obvious = self._glanced(candidate)
        if obvious is not None:
            self._trials.append(Trial(value=value, change=obvious, holds=False))
            return False
        difference = self.yardstick.difference(self.yardstick.change(candidate), self.pixels,
                                               candidate.tracing.precision, self.limit)
        fits = difference.over == 0
        self._trials.append(Trial(value=value, change=difference.largest, holds=fits))
        return fits

    def _glanced(self, candidate: Scene) -> float | None:
        """The change of `candidate` if a small picture suffices to see that it is too large, else None."""
        if self._glance is None:
            return None
        camera = self._glance.scene.camera
        change = self._glance.change(candidate.resized(camera.width, camera.height))
        return float(change.max()) if np.mean(change > self.limit) > OBVIOUS else None

    def tried(self) -> list[Trial]:
        """The trials since the last call."""
        trials, self._trials = self._trials, []
        return trials

    def named(self, objects: Collection[int]) -> str:
        """Names of objects of the scene as written."""
        return ", ".join(self.written.objects[k].name or f"object {k + 1}" for k in sorted(objects))

    def seconds(self, candidates: dict[str, Scene]) -> dict[str, float]:
        """Processor seconds of each candidate's colours, turn by turn, the least of several turns. Raises OutOfTime."""
        renderers = {name: Renderer(scene) for name, scene in candidates.items()}
        for renderer in renderers.values():
            renderer.picture(COLOUR)  # compiles
        found = {name: float("inf") for name in candidates}
        for _ in range(TURNS):
            if time.monotonic() > self.deadline:
                raise OutOfTime
            for name, renderer in renderers.items():
                found[name] = min(found[name], timed(lambda: renderer.picture(COLOUR)).cpu)
        return found
