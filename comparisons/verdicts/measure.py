"""Two pictures of one scene against each other: all numbers that a verdict may need."""

from __future__ import annotations

from functools import lru_cache
from pathlib import Path

import numpy as np

from raytruth.reference_tracer.scene.load import parse_scene

from ..execution.store import Store
from ..planes import read_planes
from . import conditioning, metrics, oracle

# To add a metric: write a file with a function of the planes of two pictures, the reference's first, that returns numbers by
# their names, and list it here. Reports show every number.
METRICS = (metrics.geometry, metrics.picture)


def measured(reference: metrics.Planes, test: metrics.Planes) -> dict[str, float | int | None]:
    """What all METRICS say of two pictures."""
    return {name: value for metric in METRICS for name, value in metric(reference, test).items()}


def answer(arguments: dict) -> dict:
    """In a worker: what the gates need and pages show of two pictures."""
    scene = parse_scene(arguments["scene"].encode(), "scene")
    a, b = (_picture(path, Path(path).stat().st_mtime_ns, scene.camera.position) for path in arguments["planes"])
    error = metrics.pixel_error(a["color"], b["color"])
    inner = error[a["interior"] & b["interior"]]
    found = {**measured(a, b), "inner max": float(np.nanmax(inner)) if np.isfinite(inner).any() else None}
    if arguments["smooth"]:
        away = error[conditioning.smooth(scene, a)]
        found["smooth color p99"] = float(np.quantile(away, 0.99)) if away.size else None
    kept = Store(Path(arguments["results"]), conditioning.FOLDER)
    if accuracies := arguments["accuracies"]:
        held = [conditioning.limits(scene, conditioning.accuracy_from(accuracy), kept) for accuracy in accuracies]
        found |= conditioning.apart(a, b, sum(held[1:], held[0]), arguments["tells_depth"])
    if arguments["literal"]:
        found |= oracle.held(scene, a, b, kept)
    return {"state": "ok", "metrics": found, "worst": metrics.worst_pixels(error)}


@lru_cache(maxsize=6)  # every renderer's picture of a scene meets all the others
def _picture(path: str, _: int, camera: tuple[float, float, float]):
    planes = read_planes(Path(path), camera)
    return {**planes, "interior": metrics.interior(planes)}
