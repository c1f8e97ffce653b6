"""Runs the cases, each in a child process, and keeps what is finished by its content."""

from __future__ import annotations

import datetime
import hashlib
import json
import os
import sys
import time
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from queue import SimpleQueue

from ..machine import machine, packages, source_hash
from ..process import Worker
from ..progress import Progress
from ..results import Gate
from .case import Case
from .results import FOLDER, CaseRecord, Transport

SECONDS_PER_CASE = 120.0
COMMAND = (sys.executable, "-m", "comparisons.transport.worker")


def run(cases: Sequence[Case], folder: Path, *, limit: float = SECONDS_PER_CASE, jobs: int = 2,
        quiet: bool = False, command: Sequence[str] = COMMAND) -> Transport:
    """Measures `cases`, `jobs` at a time, within `limit` seconds each; writes nothing but what it keeps of cases."""
    start = time.monotonic()
    (folder / FOLDER).mkdir(parents=True, exist_ok=True)
    progress = Progress(len(cases), quiet)
    idle: SimpleQueue[Worker] = SimpleQueue()
    workers = [Worker(list(command)) for _ in range(jobs)]
    for one in workers:
        idle.put(one)

    def settle(case: Case) -> CaseRecord:
        record = _finished(case, folder)
        if record is None:
            one = idle.get()
            try:
                record = _measured(case, folder, one, limit)
            finally:
                idle.put(one)
        progress.step(label=case.id)
        return record

    try:
        with ThreadPoolExecutor(jobs) as pool:
            # the long ones first, so that none is left alone at the end
            order = sorted(cases, key=lambda case: -sum(case.ladder))
            records = dict(zip((c.id for c in order), pool.map(settle, order)))
    finally:
        progress.close()
        for one in workers:
            one.close()
    return Transport(created=datetime.datetime.now(datetime.UTC).isoformat(timespec="seconds"),
                     seconds=round(time.monotonic() - start, 1), machine=machine(),
                     cases=[records[case.id] for case in cases])


def key(case: Case) -> str:
    """A hash of all that can change the case: its scene, packages, and our source, which holds the case itself."""
    content = [case.id, case.scene.hash, packages(), source_hash()]
    return hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()[:24]


def _finished(case: Case, folder: Path) -> CaseRecord | None:
    try:
        record = CaseRecord.model_validate_json((folder / FOLDER / f"{key(case)}.json").read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return None
    return record if record.planes and (folder / record.planes).exists() else None


def _measured(case: Case, folder: Path, worker: Worker, limit: float) -> CaseRecord:
    planes, start = f"{FOLDER}/{key(case)}.npz", time.monotonic()
    answer = worker.ask({"case": case.id, "planes": str(folder / planes)}, limit)
    state, message = answer["state"], answer.get("message", "")
    about = {"id": case.id, "title": case.title, "effect": case.effect, "because": case.because, "key": key(case),
             "kind": "finding" if case.is_finding else "equal", "samples": list(case.ladder),
             "judged": "Monte Carlo" if case.ladder else "deterministic", "width": case.scene.camera.width,
             "height": case.scene.camera.height, "command": f"raytruth transport {case.id}"}
    try:
        gates = [Gate.model_validate(gate) for gate in answer["facts"]["gates"]] if state == "ok" else []
        metrics = answer["facts"]["metrics"] if gates else {}
    except (KeyError, ValueError, TypeError):
        state, message, gates, metrics = "malformed", "answered something that is no measurement", [], {}
    if state != "ok":
        return CaseRecord(**about, state=state, message=message, holds=False, reason=f"not measured: {message}")
    holds = bool(gates) and all(gate.holds for gate in gates)
    record = CaseRecord(**about, state=state, holds=holds, reason=_reason(case, gates, metrics), gates=gates,
                        metrics=metrics, planes=planes, seconds=round(time.monotonic() - start, 2))
    path = folder / FOLDER / f"{key(case)}.json"
    part = path.with_suffix(".part")
    part.write_text(record.model_dump_json(), encoding="utf-8")
    os.replace(part, path)
    return record


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
