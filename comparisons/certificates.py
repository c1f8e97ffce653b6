"""Certificates of several scenes, made by the workers of a cluster, each scene by one of them."""

from __future__ import annotations

from collections.abc import Iterator

from raytruth.reference_tracer.certify.certificate import Certificate
from raytruth.reference_tracer.scene.model import Scene

from .execution.cluster import engine
from .execution.pool import Progress, Task

LIMIT = 3600.0  # seconds for one scene: the slowest shipped one takes some minutes on two cores


def run(scenes: list[Scene], cluster: str, progress: Progress, **options) -> Iterator[tuple[str, Certificate | str]]:
    """The name of each scene with its certificate, or with why there is none, as they end; `options` are those of
    `certify`."""
    tasks = [Task(f"{k}", f"certify {scene.name}", "raytruth.comparisons.certificates:answer",
                  {"scene": scene.model_dump_json(by_alias=True, exclude_none=True), **options}, LIMIT)
             for k, scene in enumerate(scenes)]
    with engine(1, progress, cluster=cluster) as pool:
        for task, found in pool.run(tasks):
            name = scenes[int(task.key)].name
            yield name, Certificate.of(found["facts"]) if found["state"] == "ok" else found["message"]


def answer(arguments: dict) -> dict:
    """What a worker answers to a task."""
    from raytruth.reference_tracer.certify import certify
    from raytruth.reference_tracer.scene.load import parse_scene

    from .execution.worker import tell

    scene = parse_scene(arguments.pop("scene").encode())
    return {"state": "ok", "facts": certify(scene, progress=tell, **arguments).document()}
