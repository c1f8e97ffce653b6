"""Pixels that two faultless renderers may show differently, because rounding decides them: how many a picture needs.

What rounding may change is measured by reference_tracer/sensitivity.py, at the price of many pictures. So it is only
measured where a pixel is beyond its limit, in a process of its own, and kept by content.
"""

from __future__ import annotations

import hashlib
import json
import os
import sys
from pathlib import Path

import numpy as np

from reference_tracer.render import UNDECIDED
from reference_tracer.scene.model import Scene

from .machine import packages, source_hash
from .metrics import Planes, pixel_error
from .process import Worker

FOLDER = "sensitivity"
PROBES = 12  # a jump that rounding decides by halves escapes n probes with probability 2^-n
NEAR_EDGES = 4.0  # a renderer with tolerances may miss one object more beside an edge: its colour jumps farther than ours
TIE = 1e-12  # relative difference of distances that fp64 cannot tell apart


def excused(scene: Scene, truth: Planes, test: Planes, limit: float, precision: int, folder: Path,
            seconds: float) -> dict[str, float | int | None]:
    """The largest error of colour outside of excused pixels, and their number.

    Undecided pixels of the truth do not count. A pixel beyond `limit` is excused if rounding to `precision` bits may
    move its colour as far (where that cannot be measured within `seconds`, none is), or if its ray meets two objects at
    once, an edge: then rounding decides which of them is hit (decision M4).
    """
    error = np.nan_to_num(pixel_error(truth["color"], test["color"]), nan=np.inf)
    decided = truth["status"] != UNDECIDED
    beyond = decided & ~(error <= limit)
    both = (truth["index"] >= 0) & (test["index"] >= 0) & (truth["index"] != test["index"])
    excuses = np.zeros_like(beyond)
    excuses[both] = np.abs(test["t"][both] - truth["t"][both]) <= TIE * truth["t"][both]
    bound = _bound(scene, precision, folder, seconds) if (beyond & ~excuses).any() else None
    excuses = beyond & (excuses | (error <= bound) if bound is not None else excuses)
    counted = error[decided & ~excuses]
    return {"undecided pixels": int((~decided).sum()), "excused pixels": int(excuses.sum()),
            "color max not excused": float(counted.max()) if counted.size else None}


def _bound(scene: Scene, precision: int, folder: Path, seconds: float) -> np.ndarray | None:
    """(h, w): how far rounding may move each pixel's colour; None if that could not be measured."""
    content = json.dumps([scene.hash, precision, PROBES, packages(), source_hash()])
    file = folder / FOLDER / f"{hashlib.sha256(content.encode()).hexdigest()[:24]}.npy"
    if not file.exists():
        file.parent.mkdir(parents=True, exist_ok=True)
        with Worker([sys.executable, "-m", "comparisons.excused"]) as worker:
            worker.ask({"scene": scene.model_dump_json(by_alias=True), "precision": precision, "file": str(file)}, seconds)
    try:
        bound = np.load(file, allow_pickle=False)
    except (OSError, ValueError, EOFError):
        return None
    return bound if bound.shape == (scene.camera.height, scene.camera.width) else None


def main() -> None:
    """The child: measures the maps it is asked for, one line of JSON each."""
    from reference_tracer.scene.load import parse_scene
    from reference_tracer.sensitivity import OBJECT, sensitivity

    answers = os.fdopen(os.dup(1), "w", buffering=1)
    os.dup2(2, 1)
    for line in sys.stdin:
        request = json.loads(line)
        found = sensitivity(parse_scene(request["scene"].encode(), "scene"), "exact", request["precision"], PROBES)
        part = Path(request["file"]).with_suffix(".part")
        with part.open("wb") as stream:
            np.save(stream, np.where(found.risk & OBJECT, NEAR_EDGES, 1.0) * found.bound, allow_pickle=False)
        os.replace(part, request["file"])
        answers.write(json.dumps({"state": "ok"}) + "\n")


if __name__ == "__main__":
    main()
