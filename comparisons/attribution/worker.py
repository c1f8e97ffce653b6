"""What a worker does for an attribution: two renderers that may crash, one of them wrong on purpose."""

from __future__ import annotations


def answer(request: dict) -> dict:
    """In a worker: the attribution of two renderers on a scene, and whether their comparison differs."""
    from pathlib import Path

    from reference_tracer.scene.load import parse_scene

    from ..execution.store import Store
    from ..verdicts import conditioning
    from ..verdicts.measure import verdict_on
    from . import side
    from .attribute import attribute
    from .records import Judged

    scene = parse_scene(request["scene"].encode(), "scene")
    a = side.of_renderer(request["a"])
    b = side.of_fault(request["fault"]) if request["fault"] is not None else side.of_renderer(request["b"])
    found, reason = None, ""
    if request["fault"] is not None:
        verdict, reason, _ = verdict_on(scene, request["a"], a(scene), b(scene), Store(Path(request["results"]), conditioning.FOLDER))
        found = verdict == "differs"
    judged = Judged(found=found, reason=reason, attribution=attribute(scene, a, b))
    return {"state": "ok", "judged": judged.model_dump(mode="json")}
