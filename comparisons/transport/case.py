"""A case: one effect, a scene, what Mitsuba makes of it, and what theory says it must make."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import numpy as np

from converters.mitsuba.radiance import Radiance
from reference_tracer.tracer.render import Picture
from reference_tracer.scene.model import Scene

Effect = Literal["shading", "shadow", "reflection", "refraction", "total reflection", "mixing", "multisampling"]


@dataclass(frozen=True)
class Case:
    """One comparison with Mitsuba's light transport, deterministic unless it has a ladder of samples."""

    id: str
    title: str
    effect: Effect
    because: str  # one sentence: why theory says so
    scene: Scene
    mitsuba: Callable[[Scene, int, int], Radiance]  # of a scene, samples a pixel, a seed
    predicted: Callable[[Picture], np.ndarray] | None = None
    """From the document's picture to the one that Mitsuba must show, (h, w, 3). None: they must be equal."""
    where: Callable[[Picture], np.ndarray] | None = None
    """From the document's picture to the pixels on which theory speaks, (h, w) bool. None: all."""
    ladder: tuple[int, ...] = ()
    """Samples a pixel, rising: the case is judged as Monte Carlo."""

    @property
    def is_finding(self) -> bool:
        """Whether physics and the document differ here, and the case measures how."""
        return self.predicted is not None
