"""At which resolution Mitsuba's meshes are as good as the plan: for information, no part of the planned scene."""

from __future__ import annotations

import tempfile
from pathlib import Path

import numpy as np

from reference_tracer.scene.model import Scene

from ..execution.pool import Pool
from ..runs import Request, RunStore
from .results import MeshTrial
from .yardstick import Yardstick

LADDER = (32, 64, 128, 256, 512)
LIMIT = 120.0  # seconds a run
PRECISION = 32  # Mitsuba's


def ladder(scene: Scene, yardstick: Yardstick, pixels: np.ndarray) -> list[MeshTrial]:
    """Finer and finer meshes, each in a process of its own, until one is as good on `pixels` (h, w, bool), or fails."""
    trials: list[MeshTrial] = []
    with tempfile.TemporaryDirectory(prefix="raytruth-plan-") as folder, Pool(1) as pool:
        store = RunStore(Path(folder))
        for resolution in LADDER:
            trials.append(_tried(scene, resolution, store, pool, yardstick, pixels))
            if trials[-1].state != "ok" or trials[-1].over == 0:
                break
    return trials


def _tried(scene: Scene, resolution: int, store: RunStore, pool: Pool, yardstick: Yardstick,
           pixels: np.ndarray) -> MeshTrial:
    run = store.make(Request(scene, "mitsuba-mesh", {"resolution": resolution}), pool, LIMIT)
    if run.state != "ok":
        return MeshTrial(resolution=resolution, state=run.state, message=run.message)
    change = yardstick.from_truth(store.planes(run, scene)["color"])
    difference = yardstick.difference(change, pixels, PRECISION)
    return MeshTrial(resolution=resolution, state="ok", over=difference.over, largest=difference.largest,
                     build=run.timing.build, warm=run.timing.warm)
