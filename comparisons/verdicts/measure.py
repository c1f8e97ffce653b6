"""Two pictures of one scene against each other: all numbers that a verdict may need."""

from __future__ import annotations

from functools import lru_cache
from pathlib import Path

import numpy as np

from reference_tracer.scene.load import parse_scene

from ..execution.store import Store
from ..planes import read_planes
from . import conditioning, metrics, oracle


def answer(arguments: dict) -> dict:
    """In a worker: what the gates need and pages show of two pictures."""
    scene = parse_scene(arguments["scene"].encode(), "scene")
    (a, inner_a), (b, inner_b) = (_picture(path, Path(path).stat().st_mtime_ns, scene.camera.position)
                                  for path in arguments["planes"])
    error = metrics.pixel_error(a["color"], b["color"])
    inner = error[inner_a & inner_b]
    found = {**metrics.geometry(a, b, inner_a), **metrics.picture(a, b),
             "inner max": float(np.nanmax(inner)) if np.isfinite(inner).any() else None}
    if arguments["smooth"]:
        away = error[conditioning.smooth(scene, a)]
        found["smooth color p99"] = float(np.quantile(away, 0.99)) if away.size else None
    kept = Store(Path(arguments["results"]), conditioning.FOLDER)
    if accuracies := [conditioning.Accuracy(**{name: tuple(v) if isinstance(v, list) else v for name, v in accuracy.items()})
                      for accuracy in arguments["accuracies"]]:
        held = [conditioning.limits(scene, accuracy, kept) for accuracy in accuracies]
        found |= conditioning.apart(a, b, sum(held[1:], held[0]), arguments["tells_depth"])
    if arguments["literal"]:
        found |= oracle.held(scene, a, b, kept)
    return {"state": "ok", "metrics": found, "worst": metrics.worst_pixels(error)}


@lru_cache(maxsize=6)  # every renderer's picture of a scene meets all the others
def _picture(path: str, _: int, camera: tuple[float, float, float]):
    planes = read_planes(Path(path), camera)
    return planes, metrics.interior(planes)
