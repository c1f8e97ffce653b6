"""A scene as XML that Mitsuba's own command renders, with a PLY file beside it for every object that is a mesh.

Geometry, camera and sampling are those of `convert`, by the same dictionaries. The document's light and material are no
stock plugins: what is nearest stands for them, and `DIFFERENT` says what that changes. Depth, normals, places and shapes
come as further channels (`aov`), and those are the model's.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from xml.etree import ElementTree

import numpy as np

from raytruth.converters.mesh import Mesh
from raytruth.reference_tracer.scene.model import Material, Scene

from .dressed import dielectric, diffuse, fading_point, mirror, rgb
from .sensor import sensor_parts
from .shapes import native_parts
from .variant import mi

AOVS = "t:depth,P:position,N:sh_normal,shape:shape_index"
DIFFERENT = ("colours are not the model's: a stock point light fades with distance, glass has Fresnel's factors and opaque "
             "shadows, diffuse light goes on to other objects, and the background lights them; geometry is the model's up to "
             "max_distance, where Mitsuba's rays do not end")


def shapes(scene: Scene, stem: str, meshes: dict[int, Mesh]) -> dict[str, dict]:
    """The objects of `scene` as dictionaries of Mitsuba's; those of `meshes`, which have faces, refer to `mesh_file`s."""
    made = {}
    for k, obj in enumerate(scene.objects):
        if k in meshes:
            made[f"object-{k}"] = {"type": "ply", "filename": mesh_file(stem, k)}
        elif found := native_parts(obj, scene):
            made[f"object-{k}"] = found[0]
        if f"object-{k}" in made:
            made[f"object-{k}"]["bsdf"] = stock(obj.material)
    return made


def mesh_file(stem: str, k: int) -> str:
    """The file's name of object `k`: of its number, never of what a scene calls it."""
    return f"{stem}-object-{k}.ply"


def xml(scene: Scene, objects: dict[str, dict], about: Sequence[str]) -> bytes:
    """The file; `about` are printable lines that it tells of itself."""
    root = ElementTree.Element("scene", version="3.0.0")
    root.append(ElementTree.Comment("\n" + "".join(f"  {line}\n" for line in _harmless(about))))
    # every further sample moves off the middle of the pixel, where the model's geometry is told
    ElementTree.SubElement(root, "default", name="spp", value="1")
    sensor = sensor_parts(scene.camera)
    sensor["sampler"]["sample_count"] = "$spp"
    # Mitsuba counts the edges of a path: one to a light, and one more a generation
    path = {"type": "path", "max_depth": scene.tracing.max_depth + 2}
    parts = {"integrator": {"type": "aov", "aovs": AOVS, "color": path}, "sensor": sensor}
    middle = _middle(scene)
    for k, light in enumerate(scene.lights):
        parts[f"light-{k}"] = fading_point(light, math.dist(light.position, middle) or 1.0)
    if any(scene.background):
        parts["background"] = {"type": "constant", "radiance": rgb(scene.background)}
    _write(root, "embree_use_robust_intersections", True)
    for name, part in {**parts, **objects}.items():
        _write(root, name, part)
    ElementTree.indent(root)
    return ElementTree.tostring(root, encoding="utf-8", xml_declaration=True) + b"\n"


def stock(material: Material) -> dict:
    """The document's mixture (section 4.3.4) of stock materials: (1 - T) ((1 - R) local + R mirrored) + T refracted."""
    R, T = material.reflection, material.transparency
    bare = diffuse(material.color) if R < 1 else mirror()
    if 0 < R < 1:
        bare = {"type": "blendbsdf", "weight": R, "first": bare, "second": mirror()}
    if T == 0:
        return {"type": "twosided", "bsdf": bare}
    glass = dielectric(material.refractive_index)
    return glass if T == 1 else {"type": "blendbsdf", "weight": T, "first": bare, "second": glass}


def _middle(scene: Scene) -> np.ndarray:
    """Where a light is to be as bright as the document's: among the bounded objects."""
    bounded = [o.surface.center for o in scene.objects if o.surface.region() is not None]
    return np.mean(bounded or [o.surface.center for o in scene.objects], axis=0)


def _write(parent: ElementTree.Element, name: str, value) -> None:
    """`value`, a parameter or a plugin as Mitsuba's dictionaries have it, below `parent`."""
    add = lambda tag, **attributes: ElementTree.SubElement(parent, tag, name=name, **attributes)
    match value:
        case bool():
            add("boolean", value=str(value).lower())
        case int():
            add("integer", value=str(value))
        case float():
            add("float", value=repr(value))
        case "$spp":
            add("integer", value=value)
        case str():
            add("string", value=value)
        case {"type": "rgb", "value": colour}:
            add("rgb", value=" ".join(map(repr, colour)))
        case list():
            add("point", **dict(zip("xyz", map(repr, value))))
        case mi.ScalarTransform4f():
            rows = np.array(value.matrix, float).ravel().tolist()  # single precision, and each number exactly
            ElementTree.SubElement(add("transform"), "matrix", value=" ".join(map(repr, rows)))
        case dict():
            known = {"aov": "integrator", "path": "integrator", "perspective": "sensor", "hdrfilm": "film", "box": "rfilter",
                     "stratified": "sampler", "point": "emitter", "constant": "emitter", "sphere": "shape",
                     "rectangle": "shape", "ply": "shape"}
            plugin = ElementTree.SubElement(parent, known.get(value["type"], "bsdf"), type=value["type"], id=name)
            if known.get(value["type"]) != "shape":
                del plugin.attrib["id"]  # names within one plugin are no names of the whole scene
            for key, part in value.items():
                if key != "type":
                    _write(plugin, key, part)


def _harmless(lines: Sequence[str]) -> list[str]:
    """Lines that a comment of XML may hold: it ends at two hyphens."""
    return [line.replace("--", "- -").rstrip("-") for line in lines]
