"""Attributions made in child processes and kept by content, so that a crash costs one and nothing is made twice."""

from __future__ import annotations

import hashlib
import json
import sys
import threading
from collections import deque
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

from reference_tracer.scene.model import Scene

from .. import renderers
from ..machine import packages, source_hash
from ..process import Worker
from ..progress import Progress
from .records import Judged

FOLDER = "attributions"
COMMAND = [sys.executable, "-m", "comparisons.attribution.worker"]


@dataclass(frozen=True)
class Task:
    """Two renderers on a scene. With a `fault` ("" for none), the second is the reference with it, whatever `b` says."""

    scene: Scene
    a: str
    b: str = "exact"
    fault: str | None = None

    @property
    def key(self) -> str:
        content = [self.scene.hash, self.a, renderers.find(self.a).settings, self.b, renderers.find(self.b).settings,
                   self.fault, packages(), source_hash()]
        return hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()[:24]


@dataclass(frozen=True)
class Made:
    """What became of a task; `judged` is there if `state` is "ok"."""

    state: str
    message: str = ""
    judged: Judged | None = None


def make_all(tasks: Sequence[Task], folder: Path, *, jobs: int = 2, limit: float = 600.0,
             quiet: bool = False) -> dict[Task, Made]:
    """Every task, finished ones from `folder`; `limit` is in seconds for one. Nothing is raised for a failure."""
    (folder / FOLDER).mkdir(parents=True, exist_ok=True)
    made = {task: finished for task in tasks if (finished := _read(_file(task, folder)))}
    waiting = deque(task for task in dict.fromkeys(tasks) if task not in made)
    progress, lock = Progress(len(waiting), quiet), threading.Lock()

    def work() -> None:
        with Worker(COMMAND) as worker:
            while True:
                try:
                    task = waiting.popleft()
                except IndexError:
                    return
                answer = _make(task, folder, worker, limit)
                with lock:
                    made[task] = answer
                    progress.step(label=f"attribution: {task.scene.name}, {task.fault or task.b}")

    try:
        with ThreadPoolExecutor(jobs) as pool:
            try:
                for future in [pool.submit(work) for _ in range(min(jobs, len(waiting)))]:
                    future.result()
            finally:
                waiting.clear()  # an interrupted suite starts nothing new
    finally:
        progress.close()
    return made


def _make(task: Task, folder: Path, worker: Worker, limit: float) -> Made:
    file = _file(task, folder)
    answer = worker.ask({"scene": task.scene.model_dump_json(by_alias=True), "a": task.a, "b": task.b,
                         "fault": task.fault, "output": str(file)}, limit)
    if answer["state"] != "ok":
        return Made(answer["state"], answer.get("message", ""))
    return _read(file) or Made("malformed", "left an attribution that cannot be read")


def _file(task: Task, folder: Path) -> Path:
    return folder / FOLDER / f"{task.key}.json"


def _read(file: Path) -> Made | None:
    try:
        return Made("ok", judged=Judged.model_validate_json(file.read_text(encoding="utf-8")))
    except (OSError, ValueError):
        return None
