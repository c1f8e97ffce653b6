"""Two renderers asked the same: their pictures of derived scenes, each made once, and what may differ there."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from skimage.morphology import erosion

from reference_tracer.tracer.render import Picture
from reference_tracer.scene.model import Scene

from ..verdicts.metrics import pixel_error
from .bounds import AROUND, Accuracy, Bounds, accuracy_of, bounds

FEWEST = 4  # pixels that may always stray
CLUSTERED = 0.1  # of the strays may be whole 3 x 3 neighbourhoods


@dataclass(frozen=True)
class Pair:
    """Both pictures of a scene, and their bounds."""

    scene: Scene
    a: Picture
    b: Picture
    bound: Bounds
    accuracy: Accuracy

    @property
    def same_hit(self) -> np.ndarray:
        return (self.a.index == self.b.index) & (self.a.index >= 0)

    def color_error(self) -> np.ndarray:
        """(h, w); infinite where a colour is not finite."""
        error = pixel_error(self.a.color, self.b.color)
        return np.where(np.isnan(error), np.inf, error)

    def color_fails(self) -> np.ndarray:
        return self.bound.decided & (self.color_error() > self.bound.color)

    def one_dark(self) -> np.ndarray:
        """Where a channel differs and is unlit on one side."""
        a, b, bound = self.a.color, self.b.color, self.bound.color[..., None]
        return self.bound.decided & ((np.abs(a - b) > bound) & (np.minimum(a, b) <= bound)).any(-1)

    def both_lit(self) -> np.ndarray:
        """Where a channel differs and is lit on both sides, or is no number."""
        a, b, bound = self.a.color, self.b.color, self.bound.color[..., None]
        return self.bound.decided & (~(np.abs(a - b) <= bound) & ~(np.minimum(a, b) <= bound)).any(-1)

    def significant(self, mask: np.ndarray) -> bool:
        """Whether more pixels diverge than may stray."""
        allowed = max(FEWEST, self.accuracy.stray * mask.size)
        return bool(mask.sum() > allowed or erosion(mask, AROUND).sum() > CLUSTERED * allowed)


class Asked:
    """Makes pictures by both renderers, and keeps them."""

    def __init__(self, a: Callable[[Scene], Picture], b: Callable[[Scene], Picture],
                 progress: Callable[[str], None] = lambda scene: None):
        self.renderers, self.progress = (a, b), progress
        self._pairs: dict[str, Pair] = {}

    def pair(self, scene: Scene) -> Pair:
        if scene.hash not in self._pairs:
            self.progress(scene.name)
            a, b = (make(scene) for make in self.renderers)
            accuracy = accuracy_of([a, b])
            self._pairs[scene.hash] = Pair(scene, a, b, bounds(scene, accuracy), accuracy)
        return self._pairs[scene.hash]
