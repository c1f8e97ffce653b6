"""A scene with materials and lights of Mitsuba's own, for Mitsuba's own light transport."""

from __future__ import annotations

import math
from collections.abc import Callable

from raytruth.reference_tracer.backend import backend
from raytruth.reference_tracer.errors import UnsupportedError
from raytruth.reference_tracer.scene.model import Light, Material, Object, Scene, Tracing

from . import plugins  # noqa: F401  registers them
from .shapes import native
from .variant import mi

FAR = 1e6  # a light of the document at this distance is Mitsuba's directional one, to 1e-5 of an angle
Dress = Callable[[Object], dict]


def dressed(scene: Scene, dress: Dress, lights: dict[str, dict] | None = None) -> mi.Scene:
    """The objects of `scene` as native shapes with what `dress` gives each: {"bsdf": ..., "emitter": ...}.

    `lights` are further plugins. Raises UnsupportedError for an object that Mitsuba has no exact shape for, and for what
    no light transport does: decisions F1 to F4.
    """
    for name in ("lights", "ambient", "shadows", "range"):
        if (asked := getattr(scene.tracing, name)) != getattr(Tracing(), name):
            raise UnsupportedError(f"Mitsuba's own light transport adds lights, dims them at every crossing and ends no ray "
                                   f"early; it has no counterpart of tracing.{name} {asked}")
    if hidden := [k for k, obj in enumerate(scene.objects) if not obj.shadow]:
        raise UnsupportedError(f"in Mitsuba's own light transport every object casts a shadow; object {hidden[0]} must not")
    backend()  # a machine without LLVM is told so in one line
    parts = {}
    # fp32 has few digits left near us on a plane that reaches to far lights, or as far as many generations could
    near = scene.model_copy(update={"lights": ()}).traced_with(max_depth=0)
    for k, obj in enumerate(scene.objects):
        shape = native(obj, near, dress(obj))
        if shape is None:
            raise UnsupportedError(f"Mitsuba has no exact shape for object {k}, a {obj.surface.type}")
        parts[f"object-{k}"] = shape[0]
    return mi.load_dict({"type": "scene", "embree_use_robust_intersections": True, **parts, **(lights or {})})


def rgb(color) -> dict:
    return {"type": "rgb", "value": [float(c) for c in color]}


def diffuse(color) -> dict:
    return {"type": "diffuse", "reflectance": rgb(color)}


def mirror(reflection: float = 1.0) -> dict:
    """A mirror without Fresnel's factors."""
    return {"type": "conductor", "material": "none", "specular_reflectance": rgb([reflection] * 3)}


def dielectric(refractive_index: float, reflected: float = 1.0) -> dict:
    """Glass with Fresnel's factors; `reflected` scales what it reflects, total reflection included."""
    return {"type": "dielectric", "int_ior": refractive_index, "ext_ior": 1.0,
            "specular_reflectance": rgb([reflected] * 3), "specular_transmittance": rgb([1.0] * 3)}


def document(material: Material) -> dict:
    """The document's material, by a plugin of ours."""
    return {"type": "document", "color": mi.ScalarColor3f(*material.color), "reflection": material.reflection,
            "transparency": material.transparency, "refractive_index": material.refractive_index}


def area(radiance) -> dict:
    return {"type": "area", "radiance": rgb(radiance)}


def sun(light: Light) -> dict:
    """A light at a distance of about FAR as a directional one: irradiance pi * brightness."""
    return {"type": "directional", "direction": [-c for c in light.position],
            "irradiance": rgb([math.pi * b for b in light.brightness])}


def steady_point(light: Light) -> dict:
    """The document's light, by a plugin of ours."""
    return {"type": "steady_point", "position": mi.ScalarPoint3f(*light.position),
            "brightness": mi.ScalarColor3f(*light.brightness)}


def fading_point(light: Light, distance: float) -> dict:
    """A physical point light, as bright as the document's at one `distance`."""
    return {"type": "point", "position": list(light.position),
            "intensity": rgb([math.pi * b * distance**2 for b in light.brightness])}
