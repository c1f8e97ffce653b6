"""Where a whole ray history has no edge: away from silhouettes, in a picture with mirrors, glass and shadows."""

from __future__ import annotations

import numpy as np

from reference_tracer.scene.model import Scene
from reference_tracer.sensitivity import perturbed

from .metrics import interior, uniform_around


def smooth(scene: Scene, planes: dict[str, np.ndarray]) -> np.ndarray:
    """Pixels that lie away from silhouettes seen directly, in mirrors or through glass, and from shadows' edges. (h, w)

    Every ray of every generation of the 3 x 3 pixels around meets the same objects, reaches as many lights and is
    totally reflected or not. `planes` are the reference's.
    """
    picture, signatures = perturbed(scene, "exact", 0.0, seed=0)
    shape = picture.t.shape
    return np.logical_and.reduce([interior(planes), *(uniform_around(s.reshape(shape)) for s in signatures.values())])
