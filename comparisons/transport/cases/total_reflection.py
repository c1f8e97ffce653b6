"""Section 4.3.3.1: beyond the critical angle nothing is refracted, and nothing is lost."""

from __future__ import annotations

from reference_tracer.scene.model import Camera

from ..case import Case
from .refraction import glass, in_glass, totally_reflected
from .rooms import CORNER_LIGHT, SIZE, corner, plane, scene

NEAR_CRITICAL = 1e-3  # of the sine

# the corner under water, seen from below the surface
WATER = scene("water", corner() + [plane((0.0, 1.6, 0.0), (0.0, 1.0, 0.0), transparency=1.0, refractive_index=1.33)],
              [CORNER_LIGHT], Camera(position=(2.0, -0.2, -2.5), direction=(-0.75, 0.5, 1.0), fov=60.0, **SIZE),
              max_depth=20, max_distance=300.0)


def reflecting(scene, samples, seed):
    """Stock glass that reflects as Fresnel's equations say: everything, beyond the critical angle."""
    return in_glass(scene, samples, seed, reflected=1.0)


def _beyond(picture):
    return totally_reflected(picture, NEAR_CRITICAL)


CASES = (
    Case("total-reflection-inside", "Under water, n = 1.33", "total reflection",
         "Beyond the critical angle Fresnel's equations reflect everything, as the document does; there a stock "
         "dielectric has no choice to make, and one sample is exact.", WATER, reflecting, where=_beyond),
    Case("total-reflection-outside", "A bubble, n = 0.8", "total reflection",
         "The same from outside: the rim of a bubble thinner than air mirrors.",
         glass(0.8, balls=1), reflecting, where=_beyond),
)
