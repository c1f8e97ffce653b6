"""The cases of a report: every comparison, and every failed run that no comparison speaks of; worst first."""

from __future__ import annotations

import math
from collections import Counter
from dataclasses import dataclass

from comparisons.results import Comparison, Gate, Results, Run, SceneRecord
from reference_tracer.errors import InputError

from .names import slug
from .words import STATES, VERDICTS


@dataclass(frozen=True)
class Case:
    """One comparison with all that it refers to."""

    comparison: Comparison
    scene: SceneRecord
    reference: Run
    test: Run

    @property
    def anchor(self) -> str:
        return slug(self.comparison.id)

    @property
    def page(self) -> str:
        return scene_page(self.scene)

    @property
    def telling_gates(self) -> list[Gate]:
        """The gates in the order in which they matter: broken ones, then those nearest to their limit."""
        return sorted(self.comparison.gates, key=lambda g: (g.holds, -_closeness(g)))

    @property
    def rank(self) -> tuple:
        """Sorts cases worst first."""
        worst = max((_closeness(g) for g in self.comparison.gates if not g.holds), default=0.0)
        nearest = max((_closeness(g) for g in self.comparison.gates if g.holds), default=0.0)
        return list(VERDICTS).index(self.comparison.verdict), -worst, -nearest, self.comparison.id


def scene_page(scene: SceneRecord) -> str:
    return f"scenes/{slug(scene.name)}.html"


def is_lower_bound(gate: Gate) -> bool:
    """Whether the gate asks for at least its limit; the document says only whether it holds."""
    if gate.value is None or math.isnan(gate.value) or gate.value == gate.limit:
        return False
    return (gate.value > gate.limit) == gate.holds


def _closeness(gate: Gate) -> float:
    """How much of its limit a gate has used: 1 at the limit, above 1 beyond it; infinite where nothing was measured."""
    if gate.value is None or not math.isfinite(gate.value):
        return math.inf
    value, limit = (gate.limit, gate.value) if is_lower_bound(gate) else (gate.value, gate.limit)
    if limit == 0:
        return math.inf if value > 0 else 0.0
    return abs(value / limit)


def cases(results: Results) -> list[Case]:
    """All comparisons, worst first. Raises InputError for one that names a scene or a run the document lacks."""
    scenes = {s.name: s for s in results.scenes}
    runs = {r.key: r for r in results.runs}
    for what, names in (("scene", [s.name for s in results.scenes]), ("run", [r.key for r in results.runs]),
                        ("comparison", [c.id for c in results.comparisons]), ("study", [s.id for s in results.series]),
                        ("effect", [e.id for e in results.effects])):
        for name, count in Counter(names).items():
            if count > 1:
                raise InputError(f"results document: {what} '{name}' is listed {count} times; "
                                 "run 'raytruth compare' again")
    found = []
    for c in results.comparisons:
        for what, key, known in (("scene", c.scene, scenes), ("run", c.reference, runs), ("run", c.test, runs)):
            if key not in known:
                raise InputError(f"results document: comparison '{c.id}' names {what} '{key}', which is not listed; "
                                 "run 'raytruth compare' again")
        found.append(Case(c, scenes[c.scene], runs[c.reference], runs[c.test]))
    return sorted(found, key=lambda case: case.rank)


def failed_runs(results: Results) -> list[Run]:
    """Every run without a picture, worst first."""
    order = list(STATES)
    failed = [run for run in results.runs if run.state != "ok"]
    return sorted(failed, key=lambda run: (order.index(run.state), run.scene, run.renderer, run.key))


@dataclass(frozen=True)
class Tally:
    """How many comparisons have each verdict; a failed run that no comparison speaks of counts as not compared."""

    counts: dict[str, int]  # verdict: comparisons
    total: int
    silent: list[Run]  # the failed runs that no comparison speaks of


def tally(found: list[Case], failed: list[Run]) -> Tally:
    compared = {case.test.key for case in found} | {case.reference.key for case in found}
    silent = [run for run in failed if run.key not in compared]
    counts = {verdict: sum(case.comparison.verdict == verdict for case in found) for verdict in VERDICTS}
    counts["not compared"] += len(silent)
    return Tally(counts, len(found) + len(silent), silent)
