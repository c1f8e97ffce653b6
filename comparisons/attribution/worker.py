"""The child process in which attributions are made: two renderers that may crash, one of them wrong on purpose."""

from __future__ import annotations

import os
from pathlib import Path

from ..worker import serve


def _answer(request: dict) -> dict:
    import numpy as np

    from reference_tracer.scene.load import parse_scene

    from ..gate import judge, tolerance_of
    from ..metrics import geometry, picture
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
    part = Path(request["output"]).with_suffix(".part")
    part.write_text(judged.model_dump_json(), encoding="utf-8")
    os.replace(part, request["output"])
    return {"state": "ok"}


if __name__ == "__main__":
    serve(_answer)
