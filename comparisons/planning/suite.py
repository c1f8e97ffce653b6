"""Plans scenes in a worker, one at a time because plans are timed, and keeps what is finished by its content."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import ExitStack
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from pydantic import ValidationError

from reference_tracer.tracer.image_files import to_8_bit
from reference_tracer.scene.load import parse_scene
from reference_tracer.scene.model import Scene

from ..execution import store
from ..execution.machine import machine
from ..execution.pool import Pool, Progress, Task, complete
from ..execution.store import Store
from ..execution.worker import tell
from . import planner, results
from .results import PLANES, Made

LONGEST = 3600.0  # seconds of one plan: decisions have a limit of their own


def run(scenes: Sequence[Scene], tolerance: float, folder: Path | None, *, limit: float = planner.LIMIT,
        with_mesh: bool = False, progress: Progress | None = None) -> Iterator[Made]:
    """The plan of every scene as soon as it is made, then also part of the document in `folder`, if there is one.

    `limit` is in seconds, for the decisions of one scene.
    """
    with ExitStack() as stack:
        kept = Store(folder or Path(stack.enter_context(TemporaryDirectory(prefix="raytruth-plan-"))), PLANES)
        pool, here = stack.enter_context(Pool(1, progress)), machine()
        for scene in scenes:
            key = store.key(scene.hash, scene.name, tolerance, limit, with_mesh, here.processor, here.cores,
                            made_by=("comparisons.planning.suite",))
            task = Task(key, scene.name, "comparisons.planning.suite:answer", {
                "scene": scene.model_dump_json(by_alias=True), "tolerance": tolerance, "limit": limit,
                "with_mesh": with_mesh, "planes": str(kept.file(key))}, LONGEST)
            made = complete([task], kept, pool, Made.model_validate_json, partial(_settled, kept), arrays=True)[key]
            if made.plan and folder is not None:
                results.add(made.plan, folder)
            yield made


def _settled(kept: Store, task: Task, answer: dict) -> Made:
    try:
        made = Made.model_validate(answer)
    except ValidationError:
        return Made(state="malformed", message="answered what is no plan")
    return made.plan and made.model_copy(update={"plan": made.plan.model_copy(
        update={"planes": kept.relative(task.key)})}) or made


def answer(arguments: dict) -> dict:
    """In a worker: plans a scene, and writes its pictures."""
    found = planner.plan(parse_scene(arguments["scene"].encode(), "scene"), arguments["tolerance"],
                         limit=arguments["limit"], with_mesh=arguments["with_mesh"], progress=tell)
    store.save(Path(arguments["planes"]), color=to_8_bit(found.color), change=found.change.astype(np.float32))
    return {"state": "ok", "plan": found.plan.model_dump(mode="json")}
