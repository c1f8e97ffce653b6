"""The scene as written, with exact intersections, and how far other pictures of it are away."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from reference_tracer.tracer.render import render
from reference_tracer.scene.model import Scene
from reference_tracer.tracer.sensitivity import sensitivity

COLOUR = ("color",)  # the plane that a tolerance is about
MOST_EXCUSED = 1e-3  # share of the pixels; if rounding decides more of them, it is no excuse but a reason for fp64


def truth_of(scene: Scene) -> Scene:
    """`scene` with exact intersections in double precision, whatever it says of its own."""
    objects = tuple(o.model_copy(update={"first_hit": None}) for o in scene.objects)
    return scene.model_copy(update={"objects": objects}).traced_with(precision=64)


@dataclass(frozen=True)
class Difference:
    """How far a picture is from the truth on some pixels."""

    largest: float  # of any channel; of pixels that are not excused
    excused: int
    excused_largest: float
    over: int  # pixels beyond the limit that are not excused


class Yardstick:
    """Measures pictures of `scene` against the truth, at the size of `scene`."""

    def __init__(self, scene: Scene, tolerance: float):
        self.scene, self.tolerance = truth_of(scene), tolerance
        self.color = render(self.scene, "exact", planes=COLOUR).color
        self._bounds: dict[int, np.ndarray] = {}

    def change(self, candidate: Scene) -> np.ndarray:
        """(h, w): the largest change of a channel of every pixel in `candidate`; infinite where it is not finite."""
        return self.from_truth(render(candidate, "exact", planes=COLOUR).color)

    def from_truth(self, color: np.ndarray) -> np.ndarray:
        change = np.abs(color - self.color).max(axis=-1)
        return np.where(np.isfinite(change), change, np.inf)

    def difference(self, change: np.ndarray, pixels: np.ndarray, precision: int,
                   limit: float | None = None) -> Difference:
        """What counts of `change` on `pixels` (h, w, bool), for a picture computed in `precision` bits.

        A pixel over `limit` (default: the tolerance) is excused if rounding to that precision alone may change it as much; the map that
        says so is measured only if few enough pixels ask for it.
        """
        over = (change > (self.tolerance if limit is None else limit)) & pixels
        excused = np.zeros_like(over)
        if 0 < over.sum() <= self.most_excused(pixels):
            excused = over & (change <= self._bound(precision))
        rest = change[pixels & ~excused]
        return Difference(float(rest.max(initial=0.0)), int(excused.sum()), float(change[excused].max(initial=0.0)),
                          int((over & ~excused).sum()))

    @staticmethod
    def most_excused(pixels: np.ndarray) -> int:
        return int(MOST_EXCUSED * pixels.sum())

    def _bound(self, precision: int) -> np.ndarray:
        if precision not in self._bounds:
            self._bounds[precision] = sensitivity(self.scene, "exact", precision).bound
        return self._bounds[precision]
