"""Attributions made in workers and kept by content, so that a crash costs one and nothing is made twice."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from pydantic import ValidationError

from reference_tracer.scene.model import Scene

from .. import renderers
from ..execution import pool as pools
from ..execution import store
from ..execution.pool import Pool
from .records import Made

FOLDER = "attributions"
SECONDS = 600.0  # of one


@dataclass(frozen=True)
class Task:
    """Two renderers on a scene. With a `fault` ("" for none), the second is the reference with it, whatever `b` says."""

    scene: Scene
    a: str
    b: str = "exact"
    fault: str | None = None

    @cached_property
    def key(self) -> str:
        sides = [renderers.find(name) for name in (self.a, self.b)]
        return store.key(self.scene.hash, [side.content for side in sides], self.fault,
                         made_by=("comparisons.attribution.worker", *(name for side in sides for name in side.code)))


def make_all(tasks: Sequence[Task], folder: Path, pool: Pool, limit: float = SECONDS) -> dict[Task, Made]:
    """Every task, finished ones from `folder`; `limit` is in seconds for one. Nothing is raised for a failure."""
    found = pools.complete([pools.Task(task.key, f"attribution: {task.scene.name}, {task.fault or task.b}",
                                       "comparisons.attribution.worker:answer", {
        "scene": task.scene.model_dump_json(by_alias=True), "a": task.a, "b": task.b, "fault": task.fault,
        "results": str(folder)},
        limit, "attribution") for task in tasks], store.Store(folder, FOLDER), pool, Made.model_validate_json, _settled)
    return {task: found[task.key] for task in tasks}


def _settled(task: pools.Task, answer: dict) -> Made:
    try:
        return Made.model_validate(answer)
    except ValidationError:
        return Made(state="malformed", message="answered what is no attribution")
