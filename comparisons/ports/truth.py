"""What the reference answers to a case, and how far a port may be from it: kept by content, made when first needed."""

from __future__ import annotations

from functools import partial
from pathlib import Path

import numpy as np

from raytruth.reference_tracer.tracer.film import PLANES, UNDECIDED
from raytruth.reference_tracer.tracer.given_rays import GivenWorld
from raytruth.reference_tracer.tracer.render import Picture, Renderer
from raytruth.reference_tracer.tracer.world import World

from ..execution import store
from ..execution.store import Store
from ..verdicts import conditioning
from ..verdicts.conditioning import Accuracy, Limits
from .cases import Case
from .protocol import METHODS

FOLDER = "truths"


class Truths:
    """The truths of all cases; `folder` is that of all results."""

    def __init__(self, folder: Path):
        """Raises UnwritableError."""
        self._planes, self._limits = Store(folder, FOLDER), Store(folder, conditioning.FOLDER)

    def planes(self, case: Case) -> dict[str, np.ndarray]:
        """The planes of the picture, (h, w), of rays (1, n)."""
        rays = [case.rays.o.tolist(), case.rays.d.tolist()] if case.rays else []
        key = store.key(case.scene.hash, case.level, rays, made_by=(__name__,))
        if (found := self._planes.arrays(key)) is None:
            picture = answered(case)
            found = {name: getattr(picture, name) for name in PLANES}
            store.save(self._planes.file(key), **found)
            self._planes.keep(key, {}, arrays=True)
        return found

    def limits(self, case: Case, precision: int) -> Limits:
        """How far a port of so many bits may be from the truth: planes as above."""
        return conditioning.limits(case.scene, Accuracy(precision), self._limits, METHODS[case.level], case.rays)


def answered(case: Case) -> Picture:
    """What the reference itself makes of a case."""
    return renderer(case).picture()


def renderer(case: Case) -> Renderer:
    """The reference, ready to answer a case."""
    scene = case.rays.scene(case.scene) if case.rays else case.scene
    return Renderer(scene, METHODS[case.level], world=partial(GivenWorld, given=case.rays) if case.rays else World)


def decided(planes: dict[str, np.ndarray]) -> np.ndarray:
    return planes["status"] != UNDECIDED
