"""Many random scenes: a pool renders and judges them in processes of their own; here their answers are added up."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field

from ..execution.cluster import engine
from ..execution.pool import Task

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
    worst: tuple[int, int, int] = (0, 0, -1)  # avoidably undecided hits, all hits and seed of the scene with most of them

    @classmethod
    def of(cls, answer: Answer) -> Total:
        c = answer.counts
        return cls(1, bool(answer.fault), len(answer.wrong), Counter(c),
                   (c.get("avoidable_hits", 0), c.get("hits", 0), answer.seed))

    def __add__(self, other: Total) -> Total:
        counts = Counter(self.counts)
        counts.update(other.counts)  # the sum of two counters forgets what is zero
        return Total(self.scenes + other.scenes, self.faults + other.faults, self.wrong + other.wrong, counts,
                     max(self.worst, other.worst, key=lambda worst: worst[0]))

    @property
    def undecided(self) -> float:
        """The share of hits that the method calls undecided although the oracle knows what is right."""
        return self.counts["avoidable_hits"] / max(self.counts["hits"], 1)

    def missed(self, kind: str) -> list[str]:
        """What keeps the total of one kind from holding."""
        much = self.undecided > MOST_UNDECIDED and kind not in EXCUSED
        return [text for text, holds in ((f"{self.faults:,} scene(s) failed", not self.faults),
                                         (f"{self.wrong:,} decided pixel(s) wrong", not self.wrong),
                                         (f"{self.undecided:.2%} of the hits undecided", not much)) if not holds]

    def holds(self, kind: str) -> bool:
        return not self.missed(kind)


def run(count: int, seed: int, jobs: int, method: str = "exact", cluster: str | None = None) -> Iterator[Answer]:
    """Renders and judges the scenes of `count` seeds from `seed` on. Yields answers as they end, which is not far from the
    order of the seeds."""
    tasks = [Task(str(k), f"scene {k}", "raytruth.comparisons.random_scenes.worker:answer", {"seed": k, "method": method},
                  LIMIT, process=f"random scenes {k // RENEWED}") for k in range(seed, seed + count)]
    with engine(jobs, cluster=cluster) as pool:
        for task, answer in pool.run(tasks):
            yield _read(task, answer)


def _read(task: Task, answer: dict) -> Answer:
    if answer["state"] == "ok":
        return Answer(**answer["facts"])
    from .grammar import draw

    drawn = draw(task.arguments["seed"])
    return Answer(drawn.seed, drawn.kind, sorted(drawn.traits), fault=answer["message"])
