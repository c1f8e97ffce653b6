"""Runs of contestants are interleaved, so that whatever slows the machine down slows both; only ratios are compared.

Wall time decides on a quiet machine. Where other programs kept the cores busy, the processor time of the contestants
decides instead: it counts the work of all threads whether or not they had to wait for a core.
"""

from __future__ import annotations

import os
import resource
import statistics
import time
from collections.abc import Callable
from dataclasses import dataclass

from .document import Clock, Row, Seconds, Spread

QUIET = 0.1  # cores: below this, other programs do not change a ratio by more than a few percent


@dataclass(frozen=True)
class Cost:
    """Seconds of one run; cpu is that of all threads together."""

    wall: float
    cpu: float


@dataclass(frozen=True)
class Contestant:
    """`run` does the work once. `compiles` says that its first run compiles kernels, which is not what is compared."""

    name: str
    run: Callable[[], Cost]
    compiles: bool = True


@dataclass
class Measured:
    """The costs of every contestant, turn by turn."""

    costs: dict[str, list[Cost]]
    first: dict[str, float]
    others: float  # cores

    def ratio(self, slow: str, fast: str, clock: Clock) -> Spread:
        """How many times longer `slow` took than `fast`, turn by turn."""
        return spread([getattr(a, clock) / max(getattr(b, clock), 1e-9)
                       for a, b in zip(self.costs[slow], self.costs[fast])])

    def seconds(self) -> dict[str, Seconds]:
        return {name: Seconds(wall=statistics.median(c.wall for c in costs),
                              cpu=statistics.median(c.cpu for c in costs), first=self.first.get(name))
                for name, costs in self.costs.items()}


def spread(values: list[float]) -> Spread:
    return Spread(median=statistics.median(values), low=min(values), high=max(values))


def timed(work: Callable[[], object]) -> Cost:
    """The cost of `work` in this process."""
    wall, cpu = time.perf_counter(), time.process_time()
    work()
    return Cost(time.perf_counter() - wall, time.process_time() - cpu)


def interleave(contestants: list[Contestant], turns: int, budget: float) -> Measured:
    """A B A B ...: every contestant `turns` times, fewer if that would take longer than `budget` seconds, but once."""
    first = {c.name: c.run().wall for c in contestants if c.compiles}
    costs: dict[str, list[Cost]] = {c.name: [] for c in contestants}
    start, busy = time.monotonic(), busy_elsewhere()
    for turn in range(1, turns + 1):
        for contestant in contestants:
            costs[contestant.name].append(contestant.run())
        spent = time.monotonic() - start
        if spent + spent / turn > budget:
            break
    return Measured(costs, first, max(busy_elsewhere() - busy, 0) / (time.monotonic() - start))


def deciding(clock: Clock | None, others: float) -> Clock:
    """The clock that was chosen, else the one that can tell where `others` cores were busy elsewhere."""
    return clock or ("wall" if others < QUIET else "cpu")


def row(key: str, what: str, measured: Measured, slow: str, fast: str, bar: float | None, clock: Clock | None = None,
        **more) -> Row:
    """The row that says how many times longer `slow` took than `fast`, judged by `clock` (None: see above)."""
    clock = deciding(clock, measured.others)
    wall, cpu = (measured.ratio(slow, fast, c) for c in ("wall", "cpu"))
    return judged(Row(key=key, what=what, bar=bar, clock=clock, wall=wall, cpu=cpu,
                      turns=len(measured.costs[fast]), others=round(measured.others, 3), seconds=measured.seconds(),
                      value=(wall if clock == "wall" else cpu).median, **more))


def judged(row: Row) -> Row:
    """The row with its value held against its bar."""
    if row.bar is None or row.value is None:
        return row
    return row.model_copy(update={"holds": row.value >= row.bar if row.sense == ">=" else row.value <= row.bar})


def busy_elsewhere() -> float:
    """Seconds that our cores were busy for others than this process and the children it has waited for."""
    busy, tick = 0.0, os.sysconf("SC_CLK_TCK")
    ours = {f"cpu{k}" for k in os.sched_getaffinity(0)}
    try:
        with open("/proc/stat", encoding="ascii") as file:
            for line in file:
                name, *jiffies = line.split()
                if name in ours:
                    user, nice, system, _, _, irq, soft = map(int, jiffies[:7])
                    busy += (user + nice + system + irq + soft) / tick
    except OSError:
        return 0.0
    own = [resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
    return busy - sum(u.ru_utime + u.ru_stime for u in own)
