"""Timed runs that take turns: A B C A B C ..., so that whatever slows the machine down slows all alike."""

from __future__ import annotations

import math
from collections.abc import Callable, Hashable
from dataclasses import dataclass

from ..bench.document import Spread
from ..bench.timing import spread
from .results import Times
from .team import Answer


@dataclass(frozen=True)
class Timed:
    """What came of one contestant's turns; `failure` is the answer that ended them early, if one did."""

    facts: list[dict]
    failure: Answer | None = None

    def times(self, prefix: str = "") -> Times | None:
        """The times called `prefix`wall and `prefix`cpu; None where they were not taken."""
        wall, cpu = self._spread(f"{prefix}wall"), self._spread(f"{prefix}cpu")
        return Times(wall=wall, cpu=cpu) if wall and cpu else None

    @property
    def fault(self) -> dict:
        """State and message of the failure; empty if there is none."""
        return {"state": self.failure["state"], "message": self.failure.get("message", "")} if self.failure else {}

    @property
    def build(self) -> Spread | None:
        return self._spread("build")

    @property
    def others(self) -> float:
        """Cores that other programs kept busy."""
        return sum(f["others"] for f in self.facts) / max(sum(f["seconds"] for f in self.facts), 1e-9)

    def _spread(self, name: str) -> Spread | None:
        values = [f[name] for f in self.facts if f.get(name) is not None]
        return spread(values) if values else None


def take_turns(contestants: dict[Hashable, Callable[[], Answer]], turns: int,
               patience: float = math.inf) -> dict[Hashable, Timed]:
    """Asks every contestant `turns` times; one that fails, or whose turns have taken `patience` seconds, no more."""
    facts: dict[Hashable, list[dict]] = {name: [] for name in contestants}
    failures: dict[Hashable, Answer] = {}
    for _ in range(turns):
        for name, ask in contestants.items():
            if name in failures or sum(f["seconds"] for f in facts[name]) > patience:
                continue
            answer = ask()
            if answer["state"] == "ok":
                facts[name].append(answer["facts"])
            else:
                failures[name] = answer
    return {name: Timed(facts[name], failures.get(name)) for name in contestants}
