"""Many random scenes: child processes render and judge them, one at a time each; here their answers are added up."""

from __future__ import annotations

import sys
from collections import Counter
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from queue import SimpleQueue

from ..process import Worker

LIMIT = 120.0  # seconds for one scene
RENEWED = 250  # scenes after which a child is replaced: its kernels fill memory
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
    counts: dict[str, int] = field(default_factory=dict)  # pixels, hits, undecided_hits, avoidable, rounding, unsettled


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
    """Renders and judges the scenes of `count` seeds from `seed` on. Yields answers in the order of the seeds."""
    workers: SimpleQueue[_Renewed] = SimpleQueue()
    everyone = [_Renewed() for _ in range(jobs)]
    for worker in everyone:
        workers.put(worker)

    def one(k: int) -> Answer:
        worker = workers.get()
        try:
            return worker.ask({"seed": k, "method": method})
        finally:
            workers.put(worker)

    pool = ThreadPoolExecutor(jobs)
    try:
        ahead = [pool.submit(one, k) for k in range(seed, seed + count)]
        for future in ahead:
            yield future.result()
    finally:
        pool.shutdown(wait=False, cancel_futures=True)
        for worker in everyone:
            worker.close()


class _Renewed:
    """A child that is replaced now and then."""

    def __init__(self):
        self.worker, self.asked = self._start(), 0

    @staticmethod
    def _start() -> Worker:
        return Worker([sys.executable, "-m", "comparisons.random_scenes.worker"])

    def ask(self, request: dict) -> Answer:
        if self.asked == RENEWED:
            self.worker.close()
            self.worker, self.asked = self._start(), 0
        self.asked += 1
        answer = self.worker.ask(request, LIMIT)
        if answer["state"] == "ok":
            return Answer(**answer["facts"])
        from .grammar import draw

        drawn = draw(request["seed"])
        return Answer(request["seed"], drawn.kind, sorted(drawn.traits), fault=answer["message"])

    def close(self) -> None:
        self.worker.stop()
        self.worker.close()
