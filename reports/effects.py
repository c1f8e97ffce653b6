"""What decisions change: each effect with all that it refers to, the misprint E1 first."""

from __future__ import annotations

from dataclasses import dataclass

from comparisons.results import Effect, Results, Run, SceneRecord

from .decisions import Decision
from .names import slug

FIRST = "E1"  # the misprint


@dataclass(frozen=True)
class Shown:
    """One effect; `missing` says why it cannot be shown, if so."""

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


def effects(results: Results) -> list[Shown]:
    """The effects in the document's order. One that names what the document lacks is shown without pictures."""
    scenes = {s.name: s for s in results.scenes}
    runs = {r.key: r for r in results.runs}
    return [_shown(e, scenes.get(e.scene), runs.get(e.baseline), runs.get(e.variant)) for e in results.effects]


def _shown(effect: Effect, scene: SceneRecord | None, baseline: Run | None, variant: Run | None) -> Shown:
    missing = ""
    if scene is None:
        missing = f"No pictures: the results do not list the scene '{effect.scene}'."
    for word, key, run in (("with the decision", effect.baseline, baseline), ("without it", effect.variant, variant)):
        if not missing and run is None:
            missing = f"No pictures: the results do not list the run '{key}' {word}."
        if not missing and run.state != "ok":
            missing = f"No pictures: the run {word} failed ({run.message or run.state})."
    return Shown(effect, scene, baseline, variant, missing)


@dataclass(frozen=True)
class Group:
    """The effects of one decision."""

    id: str
    decision: Decision | None  # None: not one of those that the reference states
    effects: list[Shown]

    @property
    def anchor(self) -> str:
        return self.id if self.decision else slug(self.id)


def by_decision(found: list[Shown], decisions: list[Decision]) -> list[Group]:
    """The misprint first, whether or not its effect was measured, then in the order of the decisions."""
    rows = {d.id: d for d in decisions}
    order = {id: k for k, id in enumerate([FIRST, *(id for id in rows if id != FIRST)])}
    ids = sorted({FIRST, *(shown.effect.decision for shown in found)}, key=lambda id: (order.get(id, len(order)), id))
    return [Group(id, rows.get(id), [s for s in found if s.effect.decision == id]) for id in ids]
