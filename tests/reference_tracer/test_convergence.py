"""The algorithm's truth converges to the model's truth: smaller steps, fewer wrong pixels, at last none."""

import numpy as np
from tracing_support import make_scene, thing

from raytruth.reference_tracer.tracer.render import render

TURN = {"axis": [1, 2, 0.3], "degrees": 50}
SCENE = make_scene(thing("sphere", (-0.9, 0.3, 4), r=0.7), thing("torus", (0.7, -0.1, 4), R=0.8, r=0.25, rotation=TURN),
                   thing("sphere", (0.1, -0.9, 3.4), r=0.05), size=(48, 36), camera={"fov": 50}, max_distance=10)


def wrong_pixels(step_size: float) -> int:
    """Pixels whose object or first root differs from the exact one."""
    exact, paper = render(SCENE, "exact"), render(SCENE.traced_with(step_size=step_size), "paper")
    with np.errstate(invalid="ignore"):
        return int(np.sum((exact.index != paper.index) | (np.abs(exact.t - paper.t) > 1e-9)))


def test_paper_converges_to_exact():
    """h = 0.4, 0.1, 0.004: chords shorter than h may be missed; of a silhouette that is a rim of width h^2."""
    assert np.all(render(SCENE, "exact").status < 2)
    coarse, middle, fine = map(wrong_pixels, (0.4, 0.1, 0.004))
    assert coarse > 20 and 0 < middle < coarse / 4 and fine == 0
