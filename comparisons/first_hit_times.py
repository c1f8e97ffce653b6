"""Times of the first-hit methods as ratios to the literal one: python -m comparisons.first_hit_times

Primary rays of 1024 x 768 pixels on each single surface of the document; the methods take turns, the median of several
turns counts, kernels are compiled before. "wrong" are pixels whose object differs from the proven answer.
"""

from __future__ import annotations

import statistics
import time

import drjit as dr
import numpy as np

from reference_tracer.backend import backend, use_threads
from reference_tracer.errors import InputError
from reference_tracer.render import camera_wave
from reference_tracer.scene import library
from reference_tracer.world import World

SURFACES = ("figure-04-plane", "figure-05-sphere", "figure-06-ellipsoid", "figure-07-torus", "figure-08-paraboloid",
            "figure-09-heart")
METHODS = ("paper", "descartes", "interval", "proof", "exact")
WIDTH, HEIGHT, TURNS = 1024, 768, 11


def measure(name: str) -> dict[str, tuple[float, int, int]]:
    """For each method: median seconds, wrong pixels, undecided pixels."""
    scene = library.scene(name).resized(WIDTH, HEIGHT).traced_with(step_size=0.1)
    arrays = backend()
    worlds = {method: World(scene, method, arrays) for method in METHODS}
    wave = camera_wave(worlds["paper"], worlds["paper"].camera_sides(), 0, WIDTH * HEIGHT, 1)
    seconds: dict[str, list[float]] = {method: [] for method in METHODS}
    found = {}
    for turn in range(TURNS + 1):
        for method, world in worlds.items():
            start = time.perf_counter()
            hit = world.nearest(wave.ray)
            dr.eval(hit)
            dr.sync_thread()
            if turn:  # the first turn compiles
                seconds[method].append(time.perf_counter() - start)
            found[method] = hit.index.numpy(), hit.undecided.numpy()
    truth, unproven = found["proof"]
    return {method: (statistics.median(seconds[method]), int(np.sum((index != truth) & ~unproven & ~undecided)),
                     int(np.sum(undecided))) for method, (index, undecided) in found.items()}


def main() -> None:
    threads = use_threads(None)
    print(f"{WIDTH} x {HEIGHT} primary rays, {threads} threads, step size 0.1, median of {TURNS} turns")
    print(f"{'':22}" + "".join(f"{method:>26}" for method in METHODS))
    for name in SURFACES:
        measured = measure(name)
        unit = measured["paper"][0]
        print(f"{name:<22}" + "".join(
            f"{1e3 * s:>8.1f} ms {s / unit:>5.2f}x {wrong:>4} wrong" + ("*" if undecided else " ")
            for s, wrong, undecided in measured.values()))
    print("* some rays undecided, and not counted as wrong")


if __name__ == "__main__":
    try:
        main()
    except InputError as error:
        raise SystemExit(f"first_hit_times: {error}") from None
