"""Measures the cases in workers, and keeps what is finished by its content."""

from __future__ import annotations

import datetime
import time
from collections.abc import Sequence
from functools import partial
from pathlib import Path

from pydantic import ValidationError

from ..execution import store
from ..execution.machine import machine
from ..execution.pool import Pool, Progress, Task, complete
from ..execution.store import Store
from ..results import Gate
from . import cases as files
from .case import Case
from .results import FOLDER, CaseRecord, Transport

SECONDS_PER_CASE = 120.0


def run(cases: Sequence[Case], folder: Path, *, limit: float = SECONDS_PER_CASE, jobs: int = 2,
        progress: Progress | None = None) -> Transport:
    """Measures `cases`, `jobs` at a time, within `limit` seconds each; writes nothing but what it keeps of cases."""
    start, kept = time.monotonic(), Store(folder, FOLDER)
    by_key = {key(case): case for case in cases}
    # the long ones first, so that none is left alone at the end
    tasks = [Task(k, case.id, "comparisons.transport.measure:answer", {"case": case.id, "planes": str(kept.file(k))}, limit)
             for k, case in sorted(by_key.items(), key=lambda item: -sum(item[1].ladder))]
    with Pool(jobs, progress) as pool:
        records = complete(tasks, kept, pool, CaseRecord.model_validate_json, partial(_settled, by_key, kept), arrays=True)
    return Transport(created=datetime.datetime.now(datetime.UTC).isoformat(timespec="seconds"),
                     seconds=round(time.monotonic() - start, 1), machine=machine(), cases=[records[k] for k in by_key])


def key(case: Case) -> str:
    """A hash of all that can change the case: its scene, and the code, which holds the case itself."""
    return store.key(case.id, case.scene.hash, made_by=("comparisons.transport.measure", files.module_of(case)))


def _settled(cases: dict[str, Case], kept: Store, task: Task, answer: dict) -> CaseRecord:
    case, state, message = cases[task.key], answer["state"], answer.get("message", "")
    about = {"id": case.id, "title": case.title, "effect": case.effect, "because": case.because, "key": task.key,
             "kind": "finding" if case.is_finding else "equal", "samples": list(case.ladder),
             "judged": "Monte Carlo" if case.ladder else "deterministic", "width": case.scene.camera.width,
             "height": case.scene.camera.height, "command": f"raytruth transport {case.id}"}
    if state == "ok":
        try:
            facts = answer["facts"]
            gates, metrics = [Gate.model_validate(gate) for gate in facts["gates"]], facts["metrics"]
            store.load(kept.file(task.key))
            return CaseRecord(**about, state=state, holds=bool(gates) and all(gate.holds for gate in gates),
                              reason=_reason(case, gates, metrics), gates=gates, metrics=metrics,
                              planes=kept.relative(task.key), seconds=facts["seconds"])
        except (KeyError, ValueError, TypeError, OSError, ValidationError):
            state, message = "malformed", "answered something that is no measurement"
    return CaseRecord(**about, state=state, message=message, holds=False, reason=f"not measured: {message}")


def _reason(case: Case, gates: list[Gate], metrics: dict) -> str:
    broken = [gate for gate in gates if not gate.holds]
    if broken:
        name, value, limit = broken[0].name, broken[0].value, broken[0].limit
        return f"{name} is {'nothing' if value is None else format(value, '.3g')}, the limit is {limit:.3g}"
    measured = {gate.name: gate.value for gate in gates}
    if case.ladder:
        close = (f"no value deviates by more than {measured['largest z']:.1f} times its noise, and the error falls "
                 f"with the power {metrics['slope']:.3f} of the samples")
    else:
        close = f"99 % of the pixels agree to {measured['color p99']:.1e}, and none away from edges differs visibly"
    if not case.is_finding:
        return close
    return (f"the pictures differ by {metrics['mean difference from the document']:.2g} in the mean and "
            f"{metrics['largest difference from the document']:.2g} at most; with what physics predicts {close}")
