"""What a worker does for an attribution: two renderers that may crash, one of them wrong on purpose."""

from __future__ import annotations


def answer(request: dict) -> dict:
    """In a worker: the attribution of two renderers on a scene, and whether their comparison differs."""
    import numpy as np

    from reference_tracer.scene.load import parse_scene

    from ..verdicts.judge import judge
    from ..verdicts.tolerances import tolerance_of
    from ..verdicts.metrics import geometry, picture
    from ..results import Run
    from . import side
    from .attribute import attribute
    from .records import Judged

    scene = parse_scene(request["scene"].encode(), "scene")
    a = side.of_renderer(request["a"])
    b = side.of_fault(request["fault"]) if request["fault"] is not None else side.of_renderer(request["b"])
    found, reason = None, ""
    if request["fault"] is not None:
        pictures = [side_(scene) for side_ in (a, b)]
        planes = [{**vars(p), "camera": np.array(scene.camera.position)} for p in pictures]
        measured = {**geometry(*planes), **picture(*planes)}
        facts = {k: v for k, v in pictures[0].metadata.items() if isinstance(v, (bool, int, float, str))}
        run = Run(key="", scene=scene.name, renderer=request["a"], title=a.title, state="ok", facts=facts, command="")
        verdict, reason, _ = judge(measured, tolerance_of(run))
        found = verdict == "differs"
    judged = Judged(found=found, reason=reason, attribution=attribute(scene, a, b))
    return {"state": "ok", "judged": judged.model_dump(mode="json")}
