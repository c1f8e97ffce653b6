"""Section 4.3.2: mirrors that keep all their light."""

from __future__ import annotations

from converters.mitsuba.dressed import diffuse, document, dressed, mirror, steady_point, sun
from converters.mitsuba.radiance import radiance
from reference_tracer.scene.model import Camera, Light

from ..case import Case
from .rooms import SIZE, ball, box, far_light, scene

LIGHT = far_light((-0.7, 1.2, -1.0))
PLANET = scene("mirror", [ball((0.0, 0.3, 0.0), 1.0, reflection=1.0), ball((0.0, -7.2, 0.5), 6.5, (0.85, 0.7, 0.45))],
               [LIGHT], Camera(position=(0.0, 1.5, -5.0), direction=(0.0, -0.25, 1.0), fov=55.0, **SIZE))
COMPANY = scene("mirrors", box() + [ball((0.2, 0.1, 1.2), 1.1, reflection=1.0),
                                    ball((1.7, -0.6, -0.4), 0.4, reflection=1.0),
                                    ball((-2.0, -0.2, 0.4), 0.8, (0.9, 0.25, 0.2)),
                                    ball((0.5, -0.7, -2.2), 0.3, (0.25, 0.8, 0.35)),
                                    ball((-0.8, -0.6, -1.6), 0.4, (0.9, 0.8, 0.3))],
                [Light(position=(-2.0, 3.4, -3.0), brightness=(0.95, 0.95, 0.95))],
                Camera(position=(0.0, 1.2, -6.0), direction=(0.0, -0.2, 1.0), fov=50.0, **SIZE), max_depth=6)


def mirrored(scene, samples, seed, *, depth: int = 3):
    """All stock: the path camera, mirror, diffuse ball, sun has three segments before the last."""
    made = dressed(scene, lambda o: {"bsdf": mirror() if o.material.reflection else diffuse(o.material.color)},
                   {"sun": sun(scene.lights[0])})
    return radiance(made, {"type": "path", "max_depth": depth, "rr_depth": 999}, scene.camera, samples, seed)


def mirrored_in_company(scene, samples, seed, *, plain=lambda o: document(o.material)):
    """Stock mirrors among bodies that light reaches and leaves once; `plain` is what those wear."""
    made = dressed(scene, lambda o: {"bsdf": mirror() if o.material.reflection else plain(o)},
                   {"lamp": steady_point(scene.lights[0])})
    generations = scene.tracing.max_depth
    return radiance(made, {"type": "path", "max_depth": generations + 2, "rr_depth": 999}, scene.camera, samples, seed)


CASES = (
    Case("mirror", "A mirror ball above a diffuse one", "reflection",
         "A conductor without a material reflects all light; with one convex diffuse body there is nothing that it "
         "could throw light on but the mirror, and three segments of a path leave no room for that.", PLANET, mirrored),
    Case("mirrors", "Two mirrors in a lit room", "reflection",
         "Stock diffuse bodies would light each other, and a stock lamp would fade; with a material that is evaluated "
         "for lights and never sampled, and a lamp that does not fade, the mirrors are Mitsuba's own.",
         COMPANY, mirrored_in_company),
)
