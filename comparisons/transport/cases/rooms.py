"""Scenes that several cases share, built so that nothing but the effect in question happens in them."""

from __future__ import annotations

import math

from converters.mitsuba.dressed import FAR
from reference_tracer.scene.model import Camera, Light, Material, Object, Scene, Tracing
from reference_tracer.surfaces import Plane, Sphere

SIZE = {"width": 320, "height": 240}
NOISY = {"width": 160, "height": 120}  # of Monte Carlo cases
LADDER = (16, 64, 256, 1024)  # samples a pixel


def ball(center, r: float, color=(1.0, 1.0, 1.0), **material) -> Object:
    return Object(surface=Sphere(center=center, r=r), material=Material(color=color, **material))


def plane(center, normal, color=(1.0, 1.0, 1.0), **material) -> Object:
    a, b, c = normal
    return Object(surface=Plane(center=center, a=a, b=b, c=c), material=Material(color=color, **material))


def far_light(direction, brightness: float = 0.9) -> Light:
    """A light so far away that its rays are parallel: the document's counterpart of a directional one."""
    length = math.sqrt(sum(c * c for c in direction))
    return Light(position=tuple(FAR * c / length for c in direction), brightness=(brightness,) * 3)


def scene(name: str, objects, lights=(), camera: Camera | None = None, background=(0.0, 0.0, 0.0), **tracing) -> Scene:
    return Scene(name=f"transport-{name}", objects=tuple(objects), lights=tuple(lights), background=background,
                 camera=camera or Camera(position=(0.0, 1.2, -6.0), direction=(0.0, -0.22, 1.0), **SIZE),
                 tracing=Tracing(**{"max_distance": 30.0, **tracing}))


def corner(reflection: float = 0.0) -> list[Object]:
    """Floor, back wall and side wall: every ray of a camera that looks into the corner meets one of them."""
    return [plane((0.0, -1.0, 0.0), (0.0, 1.0, 0.0), (0.9, 0.75, 0.5), reflection=reflection),
            plane((0.0, 0.0, 4.0), (0.0, 0.0, -1.0), (0.35, 0.6, 0.9), reflection=reflection),
            plane((-3.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.8, 0.3, 0.35), reflection=reflection)]


CORNER_LIGHT = far_light((1.0, 1.0, -1.0), 1.6)  # meets all three at one angle; none casts a shadow on another
CORNER_COSINE = 1 / math.sqrt(3)


def corner_camera() -> Camera:
    """Looks straight into the corner: no ray runs along a wall, and no mirror shows a horizon."""
    return Camera(position=(1.7, 3.7, -0.7), direction=(-1.0, -1.0, 1.0), fov=40.0, **SIZE)


def box() -> list[Object]:
    """Four walls, floor and ceiling around the origin: no ray gets out."""
    floor, wall = (0.7, 0.68, 0.6), (0.5, 0.6, 0.75)
    return [plane((0.0, -1.0, 0.0), (0.0, 1.0, 0.0), floor),
            plane((0.0, 4.0, 0.0), (0.0, -1.0, 0.0), (0.85, 0.85, 0.85)),
            plane((0.0, 0.0, 4.0), (0.0, 0.0, -1.0), wall), plane((0.0, 0.0, -7.0), (0.0, 0.0, 1.0), wall),
            plane((-4.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.75, 0.4, 0.35)),
            plane((4.0, 0.0, 0.0), (-1.0, 0.0, 0.0), (0.4, 0.65, 0.4))]


def glow(obj: Object, light: Light = CORNER_LIGHT, cosine: float = CORNER_COSINE) -> list[float]:
    """The radiance (1 - R) color cos(phi) brightness of an object that is evenly lit."""
    share = (1 - obj.material.reflection) * cosine
    return [share * c * b for c, b in zip(obj.material.color, light.brightness)]
