"""Pairs of pictures, measured in workers and kept under the keys of their runs: all numbers that a verdict may need."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import asdict, dataclass
from pathlib import Path

from pydantic import ValidationError

from raytruth.reference_tracer.scene.model import Scene

from ..document import Record
from ..execution import store
from ..execution.pool import Pool, Task, complete
from ..execution.store import Store
from ..results import Run, State
from . import conditioning
from .conditioning import Accuracy
from .tolerances import accuracy_of, measurable

FOLDER = "measured"
TRUTH = "exact"


class Measured(Record):
    """What was measured on a pair of pictures."""

    state: State = "ok"
    message: str = ""
    metrics: dict[str, float | int | None] = {}
    worst: list[dict[str, float | int]] = []


@dataclass(frozen=True)
class Pair:
    """Two finished runs of a scene. `smooth` asks for errors of colour away from every edge of a pixel's rays as well."""

    scene: Scene
    first: Run
    second: Run
    smooth: bool = False

    @property
    def accuracies(self) -> list[dict]:
        return [asdict(accuracy) for accuracy in accuracies(self.first, self.second)]

    @property
    def tells_depth(self) -> bool:
        return all(run.facts.get("tells_depth", True) for run in (self.first, self.second))

    @property
    def literal(self) -> bool:
        """Whether the literal method, at the scene's own step, is held against the truth: then its oracle is asked."""
        settings = self.second.settings
        return self.first.renderer == TRUTH and settings.get("method") == "paper" and "step_size" not in settings

    @property
    def key(self) -> str:
        return store.key(self.first.key, self.second.key, self.smooth, self.accuracies, self.literal,
                         made_by=("raytruth.comparisons.verdicts.measure",))


def accuracies(first: Run, second: Run) -> list[Accuracy]:
    """What single pixels are held to: the accuracies of the two, one of two that share their geometry; none where nothing
    is measurable, or both are the truth's."""
    if not (measurable(first) and measurable(second)):
        return []
    return list({repr(a): a for run in (first, second) if (a := accuracy_of(run))}.values())


class Measurements:
    """Of all pairs that have been asked for."""

    def __init__(self, results: Path, pool: Pool, limit: float):
        """`limit` is in seconds, of one pair."""
        self.results, self.pool, self.limit, self.store = results, pool, limit, Store(results, FOLDER)
        self._found: dict[str, Measured] = {}

    def make(self, pairs: Iterable[Pair]) -> None:
        """Measures all pairs; one that cannot be measured has a state that says so."""
        pairs = list(pairs)
        tasks = [Task(pair.key, f"{pair.first.renderer} and {pair.second.renderer}: {pair.scene.name}",
                      "raytruth.comparisons.verdicts.measure:answer", {
            "scene": pair.scene.model_dump_json(by_alias=True), "results": str(self.results), "smooth": pair.smooth,
            "accuracies": pair.accuracies, "tells_depth": pair.tells_depth, "literal": pair.literal,
            "planes": [str(self.results / run.planes) for run in (pair.first, pair.second)]},
            self.limit, "measure") for pair in pairs]
        self._make_limits([pair for pair, task in zip(pairs, tasks)
                           if self.store.find(task.key, Measured.model_validate_json) is None])
        self._found |= complete(tasks, self.store, self.pool, Measured.model_validate_json, _settled)

    def _make_limits(self, pairs: Iterable[Pair]) -> None:
        """Measures what `pairs` will be held to, all of a scene in one case: its pictures are replays of one recording, whose
        kernels would be compiled by each of several cases that begin at once. What fails here fails again, and is told,
        where a pair asks for it."""
        kept, wanted = Store(self.results, conditioning.FOLDER), {}
        for pair in pairs:
            for accuracy in pair.accuracies:
                key = conditioning.key_of(pair.scene.hash, conditioning.accuracy_from(accuracy))
                if kept.find(key, str) is None:
                    wanted.setdefault(pair.scene.hash, (pair.scene, {}))[1][key] = accuracy
        tasks = [Task(hash, f"limits: {scene.name}", "raytruth.comparisons.verdicts.conditioning:make", {
            "scene": scene.model_dump_json(by_alias=True), "results": str(self.results), "accuracies": list(missing.values())},
            self.limit * len(missing), "measure") for hash, (scene, missing) in wanted.items()]
        for _ in self.pool.run(tasks):
            pass

    def of(self, pair: Pair) -> Measured:
        """What was measured of a pair, now if it was not asked for before."""
        if pair.key not in self._found:
            self.make([pair])
        return self._found[pair.key]


def _settled(task: Task, answer: dict) -> Measured:
    try:
        return Measured.model_validate(answer)
    except ValidationError:
        return Measured(state="malformed", message="answered something that is no measurement")
