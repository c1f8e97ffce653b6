"""Our own tracer as one of the renderers."""

from __future__ import annotations

import numpy as np

from raytruth.reference_tracer.scene.model import Scene
from raytruth.reference_tracer.tracer.render import UNDECIDED, Picture
from raytruth.reference_tracer.tracer.render import render as trace

LONG = 3.0  # seconds after which a picture is not made a second time for the sake of its time


def render(scene: Scene, method: str, step_size: float | None = None, precision: int = 64,
           repeat: bool = True) -> Picture:
    """The picture of `scene` by a first-hit method; a quick one is made twice, so that compilation is timed apart."""
    if step_size is not None:
        scene = scene.traced_with(step_size=step_size)
    picture = trace(scene, method, precision=precision)
    first = picture.metadata["seconds"]
    warm = trace(scene, method, precision=precision).metadata["seconds"] if repeat and first < LONG else None
    picture.metadata |= {"first": first, "warm": warm, "undecided pixels": int(np.sum(picture.status == UNDECIDED))}
    return picture
