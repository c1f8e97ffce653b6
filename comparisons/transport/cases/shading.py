"""Section 4.3.1 without shadows: the cosine, and what physics does otherwise with lights."""

from __future__ import annotations

import math

import numpy as np

from converters.mitsuba.dressed import diffuse, dressed, fading_point, rgb, sun
from converters.mitsuba.radiance import radiance
from reference_tracer.scene.model import Camera, Light

from ..case import Case
from .rooms import SIZE, ball, far_light, plane, scene

DIRECT = {"type": "direct", "bsdf_samples": 0, "emitter_samples": 1}

BALLS = scene("balls", [ball((-1.9, 0.0, 0.0), 1.0, (0.9, 0.25, 0.2)), ball((0.3, 0.4, 0.6), 1.1, (0.3, 0.8, 0.4)),
                        ball((2.4, -0.2, 0.2), 0.9, (0.35, 0.4, 0.95))],
              [far_light((-0.2, 1.5, -2.0))],
              Camera(position=(0.0, 0.6, -6.0), direction=(0.02, -0.07, 1.0), fov=64.0, **SIZE))

LAMP = Light(position=(0.5, 3.0, -2.0), brightness=(0.9, 0.9, 0.9))
LAMP_DISTANCE = 4.0  # at which the physical lamp is as bright as the document's
LAMP_SCENE = scene("lamp", [plane((0.0, -1.0, 0.0), (0.0, 1.0, 0.0), (0.8, 0.8, 0.75)),
                            plane((0.0, 0.0, 5.0), (0.0, 0.0, -1.0), (0.6, 0.7, 0.8)),
                            ball((-1.0, 0.0, 0.5), 1.0, (0.9, 0.4, 0.3))], [LAMP])

ALBEDO, WALL = 0.6, 3.0
BOUNCES = 24  # the series is summed to 6e-6 of its value
FURNACE = scene("furnace", [ball((0.0, 0.0, 0.0), WALL, (ALBEDO, 0.5 * ALBEDO, 0.25 * ALBEDO))],
                [Light(position=(0.0, 0.0, 0.0), brightness=(0.35,) * 3)],
                Camera(position=(0.5, -0.4, -1.0), **SIZE))


def lit_by_sun(scene, samples, seed, *, strength: float = 1.0):
    """Stock diffuse surfaces under a stock directional light; `strength` scales its irradiance."""
    light = sun(scene.lights[0])
    light["irradiance"] = rgb([strength * v for v in light["irradiance"]["value"]])
    made = dressed(scene, lambda o: {"bsdf": diffuse(o.material.color)}, {"sun": light})
    return radiance(made, DIRECT, scene.camera, samples, seed)


def without_pi(scene, samples, seed):
    """The document's brightness taken for an irradiance."""
    return lit_by_sun(scene, samples, seed, strength=1 / math.pi)


def lit_by_fading_lamp(scene, samples, seed):
    made = dressed(scene, lambda o: {"bsdf": diffuse(o.material.color)},
                   {"lamp": fading_point(scene.lights[0], LAMP_DISTANCE)})
    return radiance(made, DIRECT, scene.camera, samples, seed)


def furnace(scene, samples, seed):
    """A physical lamp in the middle of a ball: at one distance from everything it does not fade."""
    made = dressed(scene, lambda o: {"bsdf": {"type": "twosided", "inner": diffuse(o.material.color)}},
                   {"lamp": fading_point(scene.lights[0], WALL)})
    return radiance(made, {"type": "path", "max_depth": BOUNCES + 1, "rr_depth": 999}, scene.camera, samples, seed)


def _faded(picture) -> np.ndarray:
    light = picture.scene.lights[0]
    distance = np.linalg.norm(np.array(light.position) - picture.position, axis=-1)
    return picture.color * (LAMP_DISTANCE / distance[..., None]) ** 2


def _furnace_law(picture) -> np.ndarray:
    albedo = np.array(picture.scene.objects[0].material.color)
    return picture.color * (1 - albedo**BOUNCES) / (1 - albedo)


CASES = (
    Case("diffuse", "Diffuse balls in parallel light", "shading",
         "A Lambertian surface of albedo c reflects c/pi of its irradiance; a far light of irradiance pi b therefore "
         "gives c b cos(phi), the document's visibleColor.", BALLS, lit_by_sun),
    Case("one-over-pi", "Brightness taken for irradiance", "shading",
         "Physics divides by pi what the document does not: an irradiance of b gives the document's picture over pi.",
         BALLS, without_pi, predicted=lambda picture: picture.color / math.pi),
    Case("fall-off", "A lamp that fades with distance", "shading",
         "A physical point light fades with the square of its distance r, the document's does not: the pictures differ "
         f"by ({LAMP_DISTANCE:g}/r)^2, where both lamps are equally bright at r = {LAMP_DISTANCE:g}.",
         LAMP_SCENE, lit_by_fading_lamp, predicted=_faded),
    Case("interreflection", "Light that diffuse walls throw on each other", "shading",
         "In the document diffuse light ends at the eye; in physics it lights other walls. In a hollow ball with the "
         "lamp in its middle every further bounce adds the same factor a, the albedo: together 1/(1 - a).",
         FURNACE, furnace, predicted=_furnace_law),
)
