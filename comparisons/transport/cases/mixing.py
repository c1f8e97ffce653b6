"""Section 4.3.4: local colour, reflection and refraction in one pixel."""

from __future__ import annotations

from converters.mitsuba.dressed import area, document, dressed, mirror, steady_point
from converters.mitsuba.radiance import radiance
from reference_tracer.scene.model import Camera, Light

from ..case import Case
from .rooms import CORNER_LIGHT, LADDER, NOISY, ball, box, corner, corner_camera, glow, scene

KALEIDOSCOPE = scene("kaleidoscope", corner(reflection=0.55), [CORNER_LIGHT], corner_camera(), max_depth=8)

EVERYTHING = scene(
    "everything",
    box() + [ball((-1.7, 0.0, 1.2), 1.0, (0.9, 0.6, 0.3), reflection=0.6),
             ball((1.0, 0.1, -0.6), 1.1, (0.5, 0.8, 0.9), transparency=0.75, reflection=0.5, refractive_index=1.4),
             ball((-0.7, -0.3, -1.6), 0.7, (0.9, 0.3, 0.6), transparency=0.5, reflection=0.5, refractive_index=0.8)],
    [Light(position=(-2.0, 3.5, -3.0), brightness=(0.9, 0.9, 0.9))],
    Camera(position=(0.0, 1.0, -5.5), direction=(0.0, -0.2, 1.0), fov=50.0, **NOISY), max_depth=4)


def glowing_mirrors(scene, samples, seed, *, glow=glow):
    """Half mirrors whose local colour is their own light."""
    made = dressed(scene, lambda o: {"bsdf": mirror(o.material.reflection), "emitter": area(glow(o))})
    depth = scene.tracing.max_depth + 1
    return radiance(made, {"type": "path", "max_depth": depth, "rr_depth": 999}, scene.camera, samples, seed)


def everything(scene, samples, seed, *, brighter: float = 1.0, integrator: str = "volpath"):
    """The whole model: materials and light by plugins of ours, the transport Mitsuba's. `brighter` scales the light."""
    light = scene.lights[0]
    light = light.model_copy(update={"brightness": tuple(brighter * b for b in light.brightness)})
    made = dressed(scene, lambda o: {"bsdf": document(o.material)}, {"lamp": steady_point(light)})
    depth = scene.tracing.max_depth + 2
    return radiance(made, {"type": integrator, "max_depth": depth, "rr_depth": 999}, scene.camera, samples, seed)


CASES = (
    Case("mirror-blend", "Three half mirrors in a corner", "mixing",
         "A surface that glows with (1 - R) color cos(phi) brightness and mirrors with R is the document's mixing; "
         "evenly lit planes glow evenly, and the corner shows them in each other.",
         KALEIDOSCOPE, glowing_mirrors),
    Case("everything", "The whole model at once", "mixing",
         "Given the document's light and material, each of Mitsuba's paths chooses reflection or refraction by its "
         "weight and divides by that chance: the mean over paths is the document's recursion.",
         EVERYTHING, everything, ladder=LADDER),
)
