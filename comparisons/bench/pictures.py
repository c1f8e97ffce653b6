"""Renders one scene several times and says what that took: python -m comparisons.bench.pictures SCENE W H SAMPLES COUNT

Prints {"wall", "cpu": seconds, "peak_gib"} as JSON. Kernels are compiled before the clock starts.
"""

from __future__ import annotations

import json
import sys

from reference_tracer.render import render
from reference_tracer.scene import library

from ..memory import peak_kib
from .timing import timed


def main(name: str, width: str, height: str, samples: str, count: str) -> None:
    scene = library.find(name)
    sized = lambda w, h: scene.resized(w, h, samples=int(samples))
    render(sized(160, 90), "exact")
    picture = sized(int(width), int(height))
    cost = timed(lambda: [render(picture, "exact") and None for _ in range(int(count))])
    print(json.dumps({"wall": cost.wall, "cpu": cost.cpu, "peak_gib": peak_kib() / 2**20}))


if __name__ == "__main__":
    main(*sys.argv[1:])
