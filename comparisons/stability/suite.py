"""Examines families in workers, and keeps what is finished by its content."""

from __future__ import annotations

import time
from collections.abc import Iterable, Sequence
from datetime import UTC, datetime
from pathlib import Path

from pydantic import ValidationError

from ..execution import store
from ..execution.machine import machine
from ..execution.pool import Pool, Progress, Task, complete
from ..execution.store import Store
from .family import SEED, Family
from .law import CONFIDENCE
from .methods import METHODS, Method
from .outcome import KINDS
from .results import FOLDER, Examined, Finding, MethodRecord, Stability

RAYS = 400
FEWEST_RAYS, MOST_RAYS = 50, 100_000  # fewer: the bands of the laws say nothing
SECONDS_PER_FAMILY = 600.0


def run(families: Sequence[Family], folder: Path, *, rays: int = RAYS, jobs: int = 2, limit: float = SECONDS_PER_FAMILY,
        progress: Progress | None = None) -> Stability:
    """The document of `families` under all methods, with `rays` random rays at every value of a difficulty; writes nothing
    but what it keeps of families."""
    start, kept = time.monotonic(), Store(folder, FOLDER)
    tasks = [Task(store.key(family.about.id, rays, made_by=("comparisons.stability.measure",)), family.about.title,
                  "comparisons.stability.measure:answer", {"family": family.about.id, "rays": rays}, limit)
             for family in families]
    with Pool(jobs, progress) as pool:
        found = complete(tasks, kept, pool, Examined.model_validate_json, _settled)
    return document_of(families, [found[task.key] for task in tasks], METHODS, rays, time.monotonic() - start)


def _settled(task: Task, answer: dict) -> Examined:
    try:
        return Examined.model_validate(answer)
    except ValidationError:
        return Examined(state="malformed", message="answered something that is no measurement")


def document_of(families: Sequence[Family], examined: Iterable[Examined], methods: Sequence[Method], rays: int,
                seconds: float) -> Stability:
    """What was examined as a document; a family that could not be is among its findings."""
    records, findings = [], []
    for family, found in zip(families, examined, strict=True):
        if found.record is None:
            findings.append(Finding(what="not measured", family=family.about.id, method="", values=[], rates=[], kinds=[],
                                    sentence=f"not measured: {found.state}: {found.message}"))
        else:
            records.append(found.record)
            findings += found.findings
    used = {m.name: m for family in families for m in (*methods, *family.variants)}
    return Stability(
        created=datetime.now(UTC).isoformat(timespec="seconds"), seconds=round(seconds, 3), machine=machine(), seed=SEED,
        rays=rays, confidence=CONFIDENCE, kinds=KINDS, families=records, findings=findings,
        methods=[MethodRecord(name=m.name, title=m.title, claims=m.claims, wrong_variant=m.wrong_variant)
                 for m in used.values()])
