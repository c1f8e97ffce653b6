"""How pixels hang on rounding: which of them two faultless renderers may show differently, and which are near no edge.

What rounding may change is measured by reference_tracer/tracer/sensitivity.py, at the price of many pictures. So it is only
measured where a pixel is beyond its limit, and kept by content.
"""

from __future__ import annotations

import numpy as np

from reference_tracer.tracer.render import UNDECIDED
from reference_tracer.scene.model import Scene
from reference_tracer.tracer.sensitivity import OBJECT, perturbed, sensitivity

from ..execution import store
from ..execution.store import Store
from .metrics import Planes, interior, pixel_error, uniform_around

FOLDER = "sensitivity"
PROBES = 12  # a jump that rounding decides by halves escapes n probes with probability 2^-n
NEAR_EDGES = 4.0  # a renderer with tolerances may miss one object more beside an edge: its colour jumps farther than ours
TIE = 1e-12  # relative difference of distances that fp64 cannot tell apart


def excused(scene: Scene, truth: Planes, test: Planes, limit: float, precision: int,
            kept: Store) -> dict[str, float | int | None]:
    """The largest error of colour outside of excused pixels, and their number.

    Undecided pixels of the truth do not count. A pixel beyond `limit` is excused if rounding to `precision` bits may
    move its colour as far, or if its ray meets two objects at once, an edge: then rounding decides which of them is hit
    (decision M4).
    """
    error = np.nan_to_num(pixel_error(truth["color"], test["color"]), nan=np.inf)
    decided = truth["status"] != UNDECIDED
    beyond = decided & ~(error <= limit)
    both = (truth["index"] >= 0) & (test["index"] >= 0) & (truth["index"] != test["index"])
    excuses = np.zeros_like(beyond)
    excuses[both] = np.abs(test["t"][both] - truth["t"][both]) <= TIE * truth["t"][both]
    if (beyond & ~excuses).any():
        excuses |= error <= bound(scene, precision, kept)
    excuses &= beyond
    counted = error[decided & ~excuses]
    return {"undecided pixels": int((~decided).sum()), "excused pixels": int(excuses.sum()),
            "color max not excused": float(counted.max()) if counted.size else None}


def bound(scene: Scene, precision: int, kept: Store, method: str = "exact") -> np.ndarray:
    """(h, w): how far rounding may move each pixel's colour."""
    key = store.key(scene.hash, method, precision, PROBES, made_by=(__name__,))
    if (found := kept.arrays(key)) is not None:
        return found["bound"]
    measured = sensitivity(scene, method, precision, PROBES)
    found = np.where(measured.risk & OBJECT, NEAR_EDGES, 1.0) * measured.bound
    store.save(kept.file(key), bound=found)
    kept.keep(key, {}, arrays=True)
    return found


def smooth(scene: Scene, planes: Planes) -> np.ndarray:
    """Pixels that lie away from silhouettes seen directly, in mirrors or through glass, and from shadows' edges. (h, w)

    Every ray of every generation of the 3 x 3 pixels around meets the same objects, reaches as many lights and is
    totally reflected or not. `planes` are the reference's.
    """
    picture, signatures = perturbed(scene, "exact", 0.0, seed=0)
    shape = picture.t.shape
    return np.logical_and.reduce([interior(planes), *(uniform_around(s.reshape(shape)) for s in signatures.values())])
