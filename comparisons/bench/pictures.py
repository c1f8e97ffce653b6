"""Renders one scene several times and says what that took: python -m comparisons.bench.pictures SCENE W H SAMPLES COUNT

Prints {"wall", "cpu": seconds, "peak_gib"} as JSON. Kernels are compiled before the clock starts; the last picture is
saved when it has stopped, so that the peak is that of making a file.
"""

from __future__ import annotations

import json
import sys
import tempfile
from pathlib import Path

from reference_tracer.tracer.image_files import planes_of, save
from reference_tracer.tracer.render import render
from reference_tracer.scene import library

from ..execution.machine import peak_kib
from .timing import timed


def main(name: str, width: str, height: str, samples: str, count: str) -> None:
    scene = library.find(name)
    sized = lambda w, h: scene.resized(w, h, samples=int(samples))
    with tempfile.TemporaryDirectory(prefix="raytruth-") as folder:
        file = Path(folder) / "picture.png"
        picture = render(sized(160, 90), "exact", planes=planes_of(file))

        def make():
            nonlocal picture
            for _ in range(int(count)):
                picture = None  # two pictures at a time would double the peak
                picture = render(sized(int(width), int(height)), "exact", planes=planes_of(file))

        cost = timed(make)
        save(picture, file)
    print(json.dumps({"wall": cost.wall, "cpu": cost.cpu, "peak_gib": peak_kib() / 2**20}))


if __name__ == "__main__":
    main(*sys.argv[1:])
