"""Section 4.3.1: hard shadows, and the light that gets through what is transparent."""

from __future__ import annotations

from converters.mitsuba.dressed import diffuse, dressed, sun
from converters.mitsuba.radiance import radiance
from reference_tracer.scene.model import Camera

from ..case import Case
from .rooms import LADDER, NOISY, SIZE, ball, far_light, plane, scene
from .shading import lit_by_sun

GROUND = [plane((0.0, -1.0, 0.0), (0.0, 1.0, 0.0), (0.75, 0.72, 0.65)),
          plane((0.0, 0.0, 5.0), (0.0, 0.0, -1.0), (0.55, 0.65, 0.75))]
CAMERA = Camera(position=(0.0, 1.6, -6.0), direction=(0.0, -0.3, 1.0), fov=55.0, **SIZE)
LIGHT = far_light((-0.8, 1.0, -0.9))

OPAQUE = scene("shadow", GROUND + [ball((-1.3, 0.0, -0.5), 0.9, (0.9, 0.35, 0.25)),
                                   ball((0.6, 0.6, -1.2), 0.45, (0.3, 0.75, 0.4)),
                                   ball((1.7, -0.3, 1.0), 0.7, (0.4, 0.45, 0.95))], [LIGHT], CAMERA)
THROUGH = 0.6
CLEAR = scene("clear-shadow", GROUND + [ball((-1.0, 0.0, -0.5), 0.95, (0.3, 0.5, 1.0), transparency=THROUGH),
                                        ball((1.4, -0.2, 0.4), 0.8, (0.95, 0.5, 0.2))], [LIGHT],
              CAMERA.model_copy(update=NOISY))


def veiled(scene, samples, seed, *, opacity=lambda transparency: 1 - transparency):
    """Stock surfaces behind a stock mask; one reflection by a diffuse surface and no more, as in the document."""
    def dress(obj):
        surface = {"type": "twosided", "inner": diffuse(obj.material.color)}
        through = obj.material.transparency
        return {"bsdf": {"type": "mask", "opacity": opacity(through), "inner": surface} if through else surface}

    made = dressed(scene, dress, {"sun": sun(scene.lights[0])})
    return radiance(made, {"type": "volpath", "max_depth": 2, "rr_depth": 999}, scene.camera, samples, seed)


CASES = (
    Case("hard-shadow", "Shadows of opaque balls", "shadow",
         "Parallel light is blocked or not; Mitsuba's integrator of direct light traces one shadow ray and lets "
         "nothing else in.",
         OPAQUE, lit_by_sun),
    Case("clear-shadow", "The shadow of a clear ball", "shadow",
         "A mask of opacity 1 - T lets a path pass with probability T and a shadow ray with weight T at every "
         "crossing, in and out: at n = 1 its mean is the document's mixing and its shadow has intensity T^2.",
         CLEAR, veiled, ladder=LADDER),
)
