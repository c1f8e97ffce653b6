"""What a report shows of a results document: comparisons, runs without a picture, effects of decisions; worst first."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass
from itertools import groupby

from raytruth.comparisons.attribution.document import WorstPixel
from raytruth.comparisons.results import Comparison, Effect, Gate, Results, Run, SceneRecord
from raytruth.reference_tracer.errors import InputError

from .text.words import STATES, VERDICTS, State, slug


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
    def is_literal(self) -> bool:
        """Whether the document's own method is under test: no independent witness of anything."""
        return self.test.renderer == "paper"

    @property
    def has_pictures(self) -> bool:
        return self.reference.state == self.test.state == "ok"

    @property
    def histories(self) -> list[WorstPixel]:
        return self.comparison.histories

    def history_anchor(self, pixel) -> str:
        """Of the rays of a pixel, which has a row and a column."""
        return f"rays-{self.anchor}-{pixel.row}-{pixel.col}"

    @property
    def followed(self) -> dict[tuple[int, int], str]:
        """Row and column of every pixel whose rays are shown: their anchor."""
        return {(pixel.row, pixel.col): self.history_anchor(pixel) for pixel in self.histories}

    @property
    def slower(self) -> float | None:
        """How many times the reference's time a warm picture takes, as far as both have one."""
        mine, truth = (run.timing.warm or run.timing.first for run in (self.test, self.reference))
        return mine / truth if mine and truth else None

    @property
    def telling_gates(self) -> list[Gate]:
        """The gates in the order in which they matter: broken ones, then those nearest to their limit."""
        return sorted(self.comparison.gates, key=lambda g: (g.holds, -_closeness(g)))

    @property
    def rank(self) -> tuple:
        """Sorts cases worst first; what is not installed, or cannot express the scene, is no fault and comes last."""
        worst = max((_closeness(g) for g in self.comparison.gates if not g.holds), default=0.0)
        nearest = max((_closeness(g) for g in self.comparison.gates if g.holds), default=0.0)
        state = STATES.get(self.test.state) if self.comparison.verdict == "not compared" else None
        harmless = state is not None and not state.is_fault
        return harmless, list(VERDICTS).index(self.comparison.verdict), -worst, -nearest, self.comparison.id


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


def verdict_counts(found: list[Case]) -> dict[str, int]:
    return {verdict: sum(case.comparison.verdict == verdict for case in found) for verdict in VERDICTS}


@dataclass(frozen=True)
class Absence:
    """Why a renderer has no picture, with all scenes that this holds for, each once."""

    renderer: str
    state: State
    reason: str
    scenes: list[str]
    commands: list[str]


def absences(rows: Iterable[tuple[str, str, str, str, str]]) -> list[Absence]:
    """Rows of (renderer, state, reason, scene, command) gathered by all but the last two, worst state first."""
    order = list(STATES)
    key = lambda row: (order.index(row[1]), row[0], row[2])
    found = [(key, list(group)) for key, group in groupby(sorted(rows, key=key), key=key)]
    return [Absence(renderer, STATES[order[state]], reason, list(dict.fromkeys(row[3] for row in group)),
                    [row[4] for row in group])
            for (state, renderer, reason), group in found]


def failed_runs(results: Results) -> list[Absence]:
    """Every run without a picture."""
    titles = {scene.name: scene.title or scene.name for scene in results.scenes}
    return absences((run.title, run.state, run.message, titles.get(run.scene, run.scene), run.command)
                    for run in results.runs if run.state != "ok")


@dataclass(frozen=True)
class ShownEffect:
    """What one decision changes, with all that it refers to; `missing` says why it cannot be shown, if so."""

    effect: Effect
    scene: SceneRecord | None
    baseline: Run | None
    variant: Run | None
    missing: str = ""

    @property
    def anchor(self) -> str:
        return slug(self.effect.id)

    @property
    def runs(self) -> list[Run]:
        return [] if self.missing else [self.baseline, self.variant]


def effects(results: Results) -> list[ShownEffect]:
    """The effects in the document's order. One that names what the document lacks is shown without pictures."""
    scenes = {s.name: s for s in results.scenes}
    runs = {r.key: r for r in results.runs}
    return [_effect(e, scenes.get(e.scene), runs.get(e.baseline), runs.get(e.variant)) for e in results.effects]


def _effect(effect: Effect, scene: SceneRecord | None, baseline: Run | None, variant: Run | None) -> ShownEffect:
    missing = ""
    if scene is None:
        missing = f"No pictures: the results do not list the scene '{effect.scene}'."
    for word, key, run in (("with the decision", effect.baseline, baseline), ("without it", effect.variant, variant)):
        if not missing and run is None:
            missing = f"No pictures: the results do not list the run '{key}' {word}."
        if not missing and run.state != "ok":
            missing = f"No pictures: the run {word} failed ({run.message or run.state})."
    return ShownEffect(effect, scene, baseline, variant, missing)
