"""Renders one scene several times and says what that took: python -m comparisons.bench.pictures SCENE W H SAMPLES COUNT

Prints {"wall", "cpu": seconds, "peak_gib"} as JSON. Kernels are compiled before the clock starts.
"""

from __future__ import annotations

import json
import sys

from reference_tracer.render import render
from reference_tracer.scene import library

from .timing import timed


def main(name: str, width: str, height: str, samples: str, count: str) -> None:
    scene = library.find(name)
    sized = lambda w, h: scene.resized(w, h, samples=int(samples))
    render(sized(160, 90), "exact")
    picture = sized(int(width), int(height))
    cost = timed(lambda: [render(picture, "exact") and None for _ in range(int(count))])
    print(json.dumps({"wall": cost.wall, "cpu": cost.cpu, "peak_gib": _peak_gib()}))


def _peak_gib() -> float:
    """Of this program alone: the kernel's ru_maxrss would begin with what the parent held when it forked."""
    with open("/proc/self/status", encoding="ascii") as file:
        kib = next(int(line.split()[1]) for line in file if line.startswith("VmHWM"))
    return kib / 2**20


if __name__ == "__main__":
    main(*sys.argv[1:])
