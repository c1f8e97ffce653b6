"""What a worker measures. Its kernels are kept in a folder that is empty at first, so that compiling is measured."""

from __future__ import annotations

import os
import time
from collections import OrderedDict
from pathlib import Path

from ..execution import store

MOST_KEPT = 64  # competitors whose recordings are kept between their turns
_kept: OrderedDict[str, object] = OrderedDict()


def answer(request: dict) -> dict:
    """In a worker that lasts: the truth, a first picture, or one turn."""
    os.environ["DRJIT_CACHE_DIR"] = request["kernels"]  # read when Dr.Jit is imported, below
    os.makedirs(request["kernels"], exist_ok=True)
    from raytruth.reference_tracer.scene.load import parse_scene

    from . import truth

    scene = parse_scene(request["scene"].encode(), "scene")
    if request["do"] == "truth":
        store.save(Path(request["truth"]), **vars(truth.make(scene)))
        return {"state": "ok"}
    return {"state": "ok", "facts": (_judged if request["do"] == "first" else _timed)(request, scene)}


def _judged(request: dict, scene) -> dict:
    """The first picture, for its accuracy; what it took to get there."""
    import drjit as dr

    from raytruth.reference_tracer.tracer.image_files import save_npz

    from ..execution.machine import forget_peak, peak_kib

    dr.flush_malloc_cache()
    forget_peak()
    found = _competitor(request, scene)
    run = found.run()
    peak = max(peak_kib(), run.program_kib)
    with store.atomically(Path(request["planes"])) as part:
        save_npz(run.picture, part)
    return {"first": run.cost.wall, "build": run.build, "peak_mib": peak / 1024, "evaluations": found.evaluations(),
            "rays": run.picture.metadata.get("rays")}


def _timed(request: dict, scene) -> dict:
    """One turn."""
    from ..bench.timing import busy_elsewhere

    fresh = request["id"] not in _kept
    found = _competitor(request, scene)
    if fresh:  # the process was replaced since: what must be compiled is compiled before the clock starts
        found.run(warm=True)
    start, before = time.monotonic(), busy_elsewhere()
    run = found.run(warm=True)
    hits = found.first_hits() if request["hits"] else None
    return {"wall": run.cost.wall, "cpu": run.cost.cpu, "build": run.build,
            "others": max(busy_elsewhere() - before, 0.0), "seconds": time.monotonic() - start,
            **({"hits_wall": hits.wall, "hits_cpu": hits.cpu} if hits else {})}


def _competitor(request: dict, scene):
    from .competitors import competitor

    if request["id"] not in _kept:
        _kept[request["id"]] = competitor(scene, request["renderer"], request["settings"], request["timed"],
                                          Path(request["truth"]) if request["truth"] else None, request["threads"])
        while len(_kept) > MOST_KEPT:
            _kept.popitem(last=False)
    return _kept[request["id"]]
