"""Every comparison of a suite that differs, as a fault or as its nature, is told where it starts to."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from raytruth.reference_tracer.scene.model import Scene

from .. import renderers
from ..execution.pool import Pool
from ..results import Comparison, Run
from .document import Attribution
from .measure import Task, make_all

LARGEST = 320  # pixels of the longer side are enough: a stage that fails does so at any size


def explained(comparisons: Sequence[Comparison], scenes: Sequence[Scene], runs: dict[str, Run], folder: Path,
              pool: Pool) -> list[Comparison]:
    """The comparisons, those that differ, or are expected to, with their attribution; None where it could not be made."""
    by_name = {scene.name: scene for scene in scenes}
    pairs = {c.id: (by_name[c.scene], runs[c.reference].renderer, runs[c.test].renderer)
             for c in comparisons if c.verdict in ("differs", "expected")}
    tasks = {id: Task(renderers.nearest(*pair).scene, *pair[1:]) for id, pair in pairs.items()}
    if not tasks:
        return list(comparisons)
    made = make_all(list(tasks.values()), folder, pool)
    return [c.model_copy(update={"attribution": _attribution(made[tasks[c.id]].judged)}) if c.id in tasks else c
            for c in comparisons]


def _attribution(judged) -> Attribution | None:
    return judged.attribution if judged else None

