"""The first-hit methods among themselves: camera rays of single surfaces, nothing shaded. No bars, only information."""

from __future__ import annotations

import drjit as dr
import numpy as np

from reference_tracer.backend import backend, use_threads
from reference_tracer.first_hit import METHODS
from reference_tracer.tracer.camera_rays import camera_wave
from reference_tracer.tracer.world import World

from ..contestants import SINGLE, THREADS
from ..options import Options, picture
from ..results import Row
from ..timing import Contestant, row, take_turns, timed

NAME = "first-hits"
CASES = SINGLE
MOST_RAYS = 640 * 480
STEP_SIZE = 0.1
BASE, TRUTH = "paper", "proof"


def measure(case: str, options: Options) -> list[Row]:
    scene = options.sized(case, MOST_RAYS).traced_with(step_size=STEP_SIZE, samples=1)
    use_threads(THREADS)
    worlds = {method: World(scene, method, backend()) for method in METHODS}
    base = worlds[BASE]
    wave = camera_wave(base, base.camera_sides(), 0, scene.camera.width * scene.camera.height, 1)
    hits = {}

    def find(method: str) -> None:
        hits[method] = worlds[method].nearest(wave.ray)
        dr.eval(hits[method])
        dr.sync_thread()

    measured = take_turns([Contestant(method, lambda method=method: timed(lambda: find(method))) for method in METHODS],
                          options.turns, options.budget)
    return [row(f"{NAME}/{case}/{method}", f"{BASE} at step size {STEP_SIZE:g} / {method}", measured, BASE, method,
                None, options.clock, picture=picture(scene), note=_wrong(hits[method], hits[TRUTH]))
            for method in METHODS if method != BASE]


def _wrong(hit, truth) -> str:
    """How many rays met another object than is proven; those that either leaves undecided do not count."""
    undecided = hit.undecided.numpy()
    wrong = (hit.index.numpy() != truth.index.numpy()) & ~undecided & ~truth.undecided.numpy()
    return f"{np.sum(wrong)} wrong rays, {np.sum(undecided)} undecided"
