"""Runs: one renderer, one scene. Each is made in its renderer's own process, and kept under a hash of its content."""

from __future__ import annotations

import hashlib
import json
import os
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from pydantic import ValidationError

from reference_tracer.image_files import load_npz
from reference_tracer.scene.model import Scene

from . import renderers
from .machine import packages, source_hash
from .metrics import Planes
from .planes import problem
from .process import Worker
from .results import RUNS, Run, Timing

TIMINGS = ("build", "first", "warm")


@dataclass(frozen=True)
class Request:
    """A run to be made."""

    scene: Scene
    renderer: str
    settings: dict = field(default_factory=dict)

    @property
    def key(self) -> str:
        """A hash of all that can change the run: scene, renderer, settings, packages, source."""
        content = [self.scene.hash, self.renderer, renderers.find(self.renderer).settings, self.settings, packages(),
                   source_hash()]
        return hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()[:24]

    @property
    def command(self) -> str:
        camera, options = self.scene.camera, "".join(f" --set {k}={v}" for k, v in sorted(self.settings.items()))
        return (f"raytruth render {self.scene.name} --with {self.renderer}{options} "
                f"--size {camera.width}x{camera.height} -o {self.scene.name}.npz")


class RunStore:
    """The folder of finished runs: `runs/KEY.npz` holds the planes, `runs/KEY.json` the record."""

    def __init__(self, folder: Path):
        self.folder = folder
        (folder / RUNS).mkdir(parents=True, exist_ok=True)

    def finished(self, request: Request) -> Run | None:
        """The finished run of an equal request, if there is one."""
        record = self.folder / RUNS / f"{request.key}.json"
        try:
            run = Run.model_validate_json(record.read_text(encoding="utf-8"))
        except (OSError, ValueError):
            return None
        return run if run.planes and (self.folder / run.planes).exists() else None

    def make(self, request: Request, worker: Worker, limit: float) -> Run:
        """Makes the run in `worker`. Whatever goes wrong is told by the run's state; nothing is raised for it."""
        renderer = renderers.find(request.renderer)
        planes = f"{RUNS}/{request.key}.npz"
        file = self.folder / planes
        file.unlink(missing_ok=True)  # left by a run that was interrupted: it must not pass for this one's
        answer = worker.ask({"renderer": request.renderer, "settings": request.settings,
                             "scene": request.scene.model_dump_json(by_alias=True),
                             "planes": str(file)}, limit)
        state, message, facts = answer["state"], answer.get("message", ""), answer.get("facts", {})
        if state == "ok" and (wrong := problem(file, request.scene)):
            state, message = "malformed", wrong
        about = {"key": request.key, "scene": request.scene.name, "renderer": request.renderer, "title": renderer.title,
                 "settings": {**renderer.settings, **request.settings}, "command": request.command}
        try:
            run = Run(**about, state=state, message=message, planes=planes if state == "ok" else None,
                      timing=Timing(**{name: facts.get(name) for name in TIMINGS}),
                      facts={k: v for k, v in facts.items() if k not in TIMINGS})
        except ValidationError:
            run = Run(**about, state="malformed", message="told facts that are no numbers or texts")
        if run.state != "ok":
            for leftover in (file, file.with_suffix(".part")):
                leftover.unlink(missing_ok=True)
        else:
            record = self.folder / RUNS / f"{request.key}.json"
            part = record.with_suffix(".part")
            part.write_text(run.model_dump_json(), encoding="utf-8")
            os.replace(part, record)
        return run

    def planes(self, run: Run, scene: Scene) -> Planes:
        """The image planes of a finished run, and the camera's position under "camera"."""
        planes, _ = load_npz(self.folder / run.planes)
        return {**planes, "camera": np.array(scene.camera.position)}
