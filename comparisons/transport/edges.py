"""What Mitsuba's own offset of ray origins may change: it is 200 times coarser than rounding.

Rays that leave a surface start up to 9e-5 (1 + |p|) away from it, so that shadows' edges, silhouettes in mirrors and
images in glass move. How far is measured as in `reference_tracer.tracer.sensitivity`: every ray is moved by that much, at
random, several times.
"""

from __future__ import annotations

import numpy as np

from reference_tracer.tracer.render import UNDECIDED, Picture
from reference_tracer.scene.model import Scene
from reference_tracer.tracer.sensitivity import ORIGIN_UNITS, SAFETY, perturbed

from ..verdicts.metrics import VISIBLE, largest_around

OFFSET = 2 * 9e-5  # relative to max(1, |p|), which is at least half of 1 + |p|
PROBES = 8


def document_side(scene: Scene) -> tuple[Picture, np.ndarray]:
    """The document's picture, and how far Mitsuba's offset may move each pixel's colour, (h, w); inf at edges."""
    truth, _ = perturbed(scene, "exact", 0.0, seed=0)
    response = np.zeros(truth.t.shape)
    for k in range(PROBES):
        probe, _ = perturbed(scene, "exact", OFFSET / ORIGIN_UNITS, seed=k + 1)
        response = np.fmax(response, np.abs(probe.color - truth.color).max(axis=-1))
    largest = largest_around(response)
    return truth, np.where((SAFETY * largest > VISIBLE) | (truth.status == UNDECIDED), np.inf, largest)
