"""Two pictures of one scene against each other: measured once, and kept under the keys of their runs."""

from __future__ import annotations

import json
from itertools import combinations

import numpy as np

from reference_tracer.scene.model import Scene

from .. import metrics
from ..gate import between, judge
from ..results import Run
from ..runs import RunStore
from .records import Pair

KEPT = "measured"


def pairs(scene: Scene, runs: list[Run], store: RunStore) -> list[Pair]:
    """All pairs of the finished `runs` of `scene`, in their order."""
    looked_at = Pictures(scene, store)
    return [_pair(scene, first, second, measured(looked_at, first, second, store)) for first, second in combinations(
        [run for run in runs if run.state == "ok"], 2)]


def measured(pictures: Pictures, first: Run, second: Run, store: RunStore) -> dict:
    """What the gates need and the matrix shows, of two finished runs."""
    kept = store.folder / KEPT / f"{first.key}-{second.key}.pair.json"
    try:
        return dict(json.loads(kept.read_text(encoding="utf-8")))
    except (OSError, ValueError, TypeError):
        pass
    (a, inner_a), (b, inner_b) = pictures.of(first), pictures.of(second)
    error = metrics.pixel_error(a["color"], b["color"])[inner_a & inner_b]
    found = {**metrics.geometry(a, b, inner_a), **metrics.differences(a, b),
             "inner max": float(np.nanmax(error)) if np.isfinite(error).any() else None}
    kept.parent.mkdir(exist_ok=True)
    part = kept.with_suffix(".part")
    part.write_text(json.dumps(found), encoding="utf-8")
    part.replace(kept)
    return found


class Pictures:
    """The planes of a scene's runs and their interior pixels, read when they are first needed."""

    def __init__(self, scene: Scene, store: RunStore):
        self.scene, self.store, self.read = scene, store, {}

    def of(self, run: Run):
        if run.key not in self.read:
            planes = self.store.planes(run, self.scene)
            self.read[run.key] = planes, metrics.interior(planes)
        return self.read[run.key]


def _pair(scene: Scene, first: Run, second: Run, m: dict) -> Pair:
    tolerance = between(first, second)
    verdict, reason, _ = judge(m, tolerance)
    return Pair(scene=scene.name, first=first.renderer, second=second.renderer, agrees=verdict == "agrees",
                tolerance=tolerance.name, broken="" if verdict == "agrees" else reason, color_p99=m["color p99"],
                color_max=m["color max"], inner_max=m["inner max"], failing=m["failing pixels"],
                mismatches=m["object mismatches"], depth_p99=m["depth p99"])
