"""Measure how much each pixel of a scene may legitimately differ, and check that the measure predicts.

examples:
  raytruth sensitivity figure-07-torus
  raytruth sensitivity figure-17-scene1 --size 640x480 --verify 8 -o map.npz

Every ray is moved by a few units of rounding, at random, several times over: where the colour answers smoothly the
bound is small, where rounding decides (a silhouette, a shadow's edge, the critical angle) it is as large as the jump.
With --verify, renders perturbed anew, and one in single precision, must stay inside the bound.
"""

from __future__ import annotations

import json
from pathlib import Path

from .. import memory
from ..arguments import require_file, resized, size, whole
from ..compile_time import compile_time_announced

BESIDE = 350  # bytes a pixel: a second picture, the differences, signatures, neighbours


def add_arguments(parser):
    parser.add_argument("scene", help="name of a shipped scene or path of a scene file")
    parser.add_argument("-o", "--output", metavar="FILE.npz", type=Path, help="save the planes bound and risk")
    parser.add_argument("--method", default="exact", help="first-hit method (default exact)")
    parser.add_argument("--size", metavar="WxH", type=size, help="picture size instead of the scene's")
    parser.add_argument("--precision", type=int, choices=(64, 32), default=32, help="rounding to predict (default 32)")
    parser.add_argument("--verify", type=whole(0, 1000), metavar="N", default=0, help="check against N newly perturbed renders")
    memory.add_argument(parser)
    parser.add_argument("--json", action="store_true", help="print the numbers as JSON")


def run(arguments) -> int:
    import numpy as np

    from raytruth.comparisons.progress import Progress
    from raytruth.reference_tracer.scene.library import find
    from raytruth.reference_tracer.tracer import sensitivity as model
    from raytruth.reference_tracer.tracer.film import PLANES
    from raytruth.reference_tracer.tracer.render import render
    from raytruth.reference_tracer.writing import atomically

    require_file(arguments.output, ".npz")
    scene = resized(find(arguments.scene), arguments.size)
    memory.require(scene, PLANES, BESIDE, arguments.memory)
    with Progress(1.0, label=scene.name) as bar, compile_time_announced(scene, bar):
        sensitivity = model.sensitivity(scene, arguments.method, arguments.precision, progress=bar.to)
    share = lambda mask: float(np.mean(mask))
    found = {"scene": scene.name, "pixels": sensitivity.bound.size,
             "bound below 1e-4": share(sensitivity.bound < 1e-4), "median bound": float(np.median(sensitivity.bound)),
             **{f"pixels at risk: {word}": int(np.sum(sensitivity.risk & bit > 0))
                for word, bit in (("object", model.OBJECT), ("light", model.LIGHT),
                                  ("total reflection", model.TOTAL_REFLECTION))}}
    if arguments.verify:
        unit = model.UNIT[arguments.precision]
        inside = [share(sensitivity.excuses(model.perturbed(scene, arguments.method, unit, seed=1000 + k)[0].color))
                  for k in range(arguments.verify)]
        found["perturbed renders inside, worst"] = min(inside)
        if arguments.precision == 32:
            single = render(scene, arguments.method, precision=32)
            found["single precision inside"] = share(sensitivity.excuses(single.color))
    if arguments.output:
        with atomically(arguments.output) as part:
            np.savez_compressed(part, bound=sensitivity.bound, risk=sensitivity.risk)
    if arguments.json:
        print(json.dumps(found))
    else:
        for name, value in found.items():
            print(f"{name:<34} {value:.6g}" if isinstance(value, float) else f"{name:<34} {value}")
    checked = [found[k] for k in ("perturbed renders inside, worst", "single precision inside") if k in found]
    return 0 if all(value >= 0.9999 for value in checked) else 1
