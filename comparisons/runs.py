"""Runs: one renderer, one scene. Each is made in its renderer's own process, and kept by its content."""

from __future__ import annotations

import json
import resource
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property, partial
from pathlib import Path

from pydantic import ValidationError

from raytruth.reference_tracer.scene.load import parse_scene
from raytruth.reference_tracer.scene.model import Scene
from raytruth.reference_tracer.tracer.image_files import save_npz

from . import meshes, renderers
from .execution import store
from .execution.pool import Pool, Task, complete
from .planes import problem, read_planes
from .results import OF_OBJECTS, RUNS, Run, Timing
from .verdicts.metrics import Planes

TIMINGS = ("build", "first", "warm")
LARGEST_FILE = 1 << 30, 256  # bytes a renderer may write into one file, and as many more a pixel


@dataclass(frozen=True)
class Request:
    """A run to be made. `changes` of its tracing and of its `camera` are how `scene` differs from the one of that name."""

    scene: Scene
    renderer: str
    settings: dict = field(default_factory=dict)
    changes: dict = field(default_factory=dict)
    camera: dict = field(default_factory=dict)

    @cached_property
    def key(self) -> str:
        """A hash of all that can change the run: scene, renderer, settings, its code, the program that it starts."""
        renderer = renderers.find(self.renderer)
        return store.key(self.scene.hash, renderer.content, self.settings, made_by=renderer.code)

    @property
    def process(self) -> str:
        """Runs of one renderer share processes."""
        return self.renderer

    @property
    def command(self) -> str:
        camera, told = self.scene.camera, (("--set", self.settings), ("--tracing", self.changes), ("--camera", self.camera))
        options = "".join(f" {option} {k}={_typed(v)}" for option, values in told for k, v in sorted(values.items()))
        return (f"raytruth render {self.scene.name} --with {self.renderer}{options} "
                f"--size {camera.width}x{camera.height} -o {self.scene.name}.npz")


def _typed(value) -> str:
    """A value as a command line takes it."""
    return json.dumps(value, separators=(",", ":")) if isinstance(value, (tuple, list)) else str(value)


class RunStore(store.Store):
    """The folder of finished runs."""

    def __init__(self, folder: Path):
        super().__init__(folder, RUNS)

    def finished(self, request: Request) -> Run | None:
        """The finished run of an equal request, if there is one."""
        run = self.find(request.key, Run.model_validate_json)
        # scenes that differ in names alone have equal pictures
        return run and run.model_copy(update={"scene": request.scene.name, "command": request.command})

    def make_all(self, requests: Sequence[Request], pool: Pool, limit: float) -> dict[str, Run]:
        """All runs by key. Whatever goes wrong is told by a run's state; nothing is raised for it. `limit`: seconds of one."""
        by_key = {r.key: r for r in requests}
        tasks = [Task(key, f"{r.renderer}: {r.scene.name}", "raytruth.comparisons.runs:make", {
            "renderer": r.renderer, "settings": r.settings, "scene": r.scene.model_dump_json(by_alias=True),
            "planes": str(self.file(key)), "results": str(self.folder.parent)}, limit, r.process) for key, r in by_key.items()]
        return complete(tasks, self, pool, Run.model_validate_json, partial(self._settled, by_key), arrays=True)

    def make(self, request: Request, pool: Pool, limit: float) -> Run:
        return self.make_all([request], pool, limit)[request.key]

    def _settled(self, requests: dict[str, Request], task: Task, answer: dict) -> Run:
        request, renderer = requests[task.key], renderers.find(requests[task.key].renderer)
        state, message, facts = answer["state"], answer.get("message", ""), answer.get("facts", {})
        if state == "ok" and (wrong := problem(self.file(task.key), request.scene)):
            state, message = "malformed", wrong
        about = {"key": task.key, "scene": request.scene.name, "renderer": request.renderer, "title": renderer.title,
                 "settings": {**renderer.settings, **request.settings}, "command": request.command}
        try:
            return Run(**about, state=state, message=message, planes=self.relative(task.key) if state == "ok" else None,
                       timing=Timing(**{name: facts.get(name) for name in TIMINGS}),
                       **{name: facts.get(name, []) for name in OF_OBJECTS},
                       facts={k: v for k, v in facts.items() if k not in (*TIMINGS, *OF_OBJECTS)})
        except ValidationError:
            return Run(**about, state="malformed", message="told facts that are no numbers or texts")

    def planes(self, run: Run, scene: Scene) -> Planes:
        """The image planes of a finished run, and the camera's position under "camera"."""
        return read_planes(self.file(run.key), scene.camera.position)


def make(arguments: dict) -> dict:
    """In a worker: renders a scene and writes its planes."""
    scene = parse_scene(arguments["scene"].encode(), "scene")
    most = LARGEST_FILE[0] + LARGEST_FILE[1] * scene.camera.width * scene.camera.height
    resource.setrlimit(resource.RLIMIT_FSIZE, (most, resource.getrlimit(resource.RLIMIT_FSIZE)[1]))
    meshes.keep_in(Path(arguments["results"]))
    picture = renderers.render(arguments["renderer"], scene, arguments["settings"])
    facts = {k: v for k, v in picture.metadata.items()
             if isinstance(v, (int, float, str, bool)) or v is None or k in OF_OBJECTS}
    with store.atomically(Path(arguments["planes"])) as part:
        save_npz(picture, part)
    return {"state": "ok", "facts": facts}
