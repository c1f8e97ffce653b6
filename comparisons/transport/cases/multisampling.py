"""Section 5: n x n samples a pixel, through Mitsuba's own camera, sampler and film."""

from __future__ import annotations

import numpy as np

from converters.mitsuba import sensor
from converters.mitsuba.dressed import diffuse, dressed, sun
from converters.mitsuba.radiance import Radiance
from converters.mitsuba.variant import mi
from reference_tracer.scene.model import Scene

from ..case import Case
from .shading import DIRECT
from .shadow import OPAQUE

SAMPLES = 4
SCENE = OPAQUE.resized(OPAQUE.camera.width, OPAQUE.camera.height, samples=SAMPLES).model_copy(
    update={"name": "transport-multisampling"})


def filmed(scene: Scene, samples: int, seed: int) -> Radiance:
    """Mitsuba's own sensor and box filter; its sampler takes the middle of each of the n x n cells of a pixel."""
    made = dressed(scene, lambda o: {"bsdf": diffuse(o.material.color)}, {"sun": sun(scene.lights[0])})
    per_pixel = scene.tracing.samples**2
    image = mi.render(made, sensor=sensor(scene.camera, per_pixel), integrator=mi.load_dict(DIRECT), spp=per_pixel,
                      seed=seed)
    mean = np.array(image, dtype=float)
    return Radiance(mean, np.zeros_like(mean), per_pixel)


CASES = (
    Case("multisampling", "4 × 4 samples a pixel", "multisampling",
         "Mitsuba's stratified sampler without jitter takes the centres of n x n cells, and its box filter their mean: "
         "the document's samples; direct light makes no further choice at random.", SCENE, filmed),
)
