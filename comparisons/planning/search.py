"""The state of a search: the scene planned so far, and trials of what else it could do without."""

from __future__ import annotations

import time
from collections.abc import Callable, Collection
from dataclasses import dataclass, field

import numpy as np

from reference_tracer.tracer.render import Renderer
from reference_tracer.scene.model import Scene

from ..bench.timing import timed
from .results import DecisionRecord, Trial
from .seen import Seen
from .yardstick import COLOUR, Yardstick

Change = Callable[[Scene], Scene]
TURNS = 5
GLANCE, LEAST_GLANCE = 4, 48  # how much smaller the picture of a first glance is; pixels of its shorter side
OBVIOUS = 0.01  # share of its pixels: far more than rounding may excuse
CHEAPER = 0.95  # of the time: a smaller gain is within the noise of a few turns


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


def changing(change: float) -> str:
    """The largest change of a picture, in words."""
    return f"a pixel changes by {change:.2g}" if change else "no pixel changes"


class OutOfTime(Exception):
    """The search has used its time: what is decided stands, the rest stays as written."""


class Search:
    """`scene` is what is planned so far, at the size of the search; `written` the scene it began with."""

    def __init__(self, yardstick: Yardstick, written: Scene, pixels: np.ndarray, limit: float, deadline: float):
        """`pixels` (h, w, bool) decide; they may change by `limit`; `deadline` is a time.monotonic()."""
        self.yardstick, self.written, self.scene = yardstick, written, written
        self.pixels, self.limit, self.deadline = pixels, limit, deadline
        self.seen = Seen(yardstick.scene, pixels)
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
