"""Many random scenes: a pool renders and judges them in processes of their own; here their answers are added up."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field

from ..execution.pool import Pool, Task

LIMIT = 120.0  # seconds for one scene
RENEWED = 250  # scenes after which a process is replaced: its kernels fill memory
MOST_UNDECIDED = 0.01  # of hits that the oracle knows; a requirement
EXCUSED = "pairs", "not defined everywhere"  # where rounding hides which object is first, or f has no value (M4, M7)


@dataclass
class Answer:
    """One scene and what became of it."""

    seed: int
    kind: str
    traits: list[str]
    fault: str = ""  # why there is no judgement: a traceback, a refusal, a time limit
    wrong: list[str] = field(default_factory=list)
    counts: dict[str, int] = field(default_factory=dict)  # pixels, hits, undecided_hits, avoidable_hits, rounding, unsettled


@dataclass
class Total:
    """Many answers, added up."""

    scenes: int = 0
    faults: int = 0
    wrong: int = 0  # decided pixels
    counts: Counter = field(default_factory=Counter)

    @classmethod
    def of(cls, *answers: Answer) -> Total:
        total = cls()
        for answer in answers:
            total.add(answer)
        return total

    def add(self, answer: Answer) -> None:
        self.scenes += 1
        self.faults += bool(answer.fault)
        self.wrong += len(answer.wrong)
        self.counts.update(answer.counts)

    @property
    def undecided(self) -> float:
        """The share of hits that the method calls undecided although the oracle knows what is right."""
        return self.counts["avoidable_hits"] / max(self.counts["hits"], 1)

    def holds(self, kind: str) -> bool:
        return not self.wrong and not self.faults and (kind in EXCUSED or self.undecided <= MOST_UNDECIDED)


def run(count: int, seed: int, jobs: int, method: str = "exact") -> Iterator[Answer]:
    """Renders and judges the scenes of `count` seeds from `seed` on. Yields answers as they end, which is not far from the
    order of the seeds."""
    tasks = [Task(str(k), f"scene {k}", "comparisons.random_scenes.worker:answer", {"seed": k, "method": method}, LIMIT,
                  process=f"random scenes {k // RENEWED}") for k in range(seed, seed + count)]
    with Pool(jobs) as pool:
        for task, answer in pool.run(tasks):
            yield _read(task, answer)


def _read(task: Task, answer: dict) -> Answer:
    if answer["state"] == "ok":
        return Answer(**answer["facts"])
    from .grammar import draw

    drawn = draw(task.arguments["seed"])
    return Answer(drawn.seed, drawn.kind, sorted(drawn.traits), fault=answer["message"])
