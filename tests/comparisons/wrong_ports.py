"""Ports that are wrong on purpose: tests/ports/cpp/tracer.cpp with one classic mistake each.

The text of the port is changed at one place a mistake; all changes are compiled into one program, and the environment
chooses which holds. It shares no code with comparisons/ports/mistaken.py, which has to recognise what it shows.
"""

from __future__ import annotations

import os
import subprocess
import tempfile
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np

from raytruth.comparisons.bench import port
from raytruth.converters.plain import plain
from raytruth.reference_tracer.scene.load import parse_scene
from raytruth.reference_tracer.scene.model import Scene

SCENE = parse_scene(b"""{"name": "every-effect", "background": [0.1, 0.15, 0.2],
  "camera": {"width": 80, "height": 60, "position": [0, 0.5, -1], "direction": [0.1, -0.12, 1]},
  "objects": [
    {"surface": {"type": "plane", "center": [0, -1, 0], "a": 0, "b": 1, "c": 0},
     "material": {"color": [0.6, 0.7, 0.5], "reflection": 0.1}},
    {"surface": {"type": "plane", "center": [0, 0, 9], "a": 0, "b": 0, "c": -1}, "material": {"color": [0.5, 0.4, 0.6]}},
    {"surface": {"type": "sphere", "center": [-1.3, -0.1, 5.5], "r": 0.9}, "material": {"color": [0.9, 0.3, 0.2]}},
    {"surface": {"type": "heart", "center": [1.6, 0.4, 3.4]}, "material": {"color": [0.7, 0.5, 0.2], "reflection": 0.1}},
    {"surface": {"type": "sphere", "center": [1.3, 0.3, 6.2], "r": 1.1},
     "material": {"color": [0.8, 0.8, 0.9], "reflection": 0.6}},
    {"surface": {"type": "ellipsoid", "center": [0.2, -0.2, 3.0], "a": 0.35, "b": 0.7, "c": 0.4},
     "rotation": {"axis": [1, 0.3, 1], "degrees": 35},
     "material": {"color": [0.2, 0.5, 0.9], "reflection": 0.2, "transparency": 0.7, "refractive_index": 1.4}},
    {"surface": {"type": "sphere", "center": [-1.0, 0.3, 2.6], "r": 0.45},
     "material": {"color": [0.4, 0.8, 0.4], "reflection": 0.1, "transparency": 0.8, "refractive_index": 0.8}}],
  "lights": [{"position": [2, 3, 0], "brightness": [0.7, 0.7, 0.6]},
             {"position": [-2, 0.7, 7.5], "brightness": [0.5, 0.4, 0.3]}],
  "tracing": {"max_distance": 14, "max_depth": 4}}""")

MIX = "(visible * (1 - R) + reflected * R) * (1 - T) + refracted * T"
TURNED = "if (dot(d, normal) > 0) normal = -normal;"
LIGHT = "light.brightness * (cos * intensity)"
TOTAL = "refracted = object.reflection > 0 ? reflected : trace(point, reflection_dir, sides, left, depth + 1);"
REFLECTED = "trace(point, reflection_dir, sides, left, depth + 1)"
REFRACTED = "trace(point, refraction_dir, through, left, depth + 1)"
THROUGH = "light_through(point, shadow_dir, distance, sides)"


@dataclass(frozen=True)
class Change:
    """`before` + `right` is text of the port, of which `right` becomes `wrong`: a statement, or an expression."""

    right: str
    wrong: str
    before: str = ""
    statement: bool = False


def statement(right: str, wrong: str, before: str = "") -> Change:
    return Change(right, wrong, before, statement=True)


CROSSED = "if (inside != sides[k]) {\n                    "  # at a step, not at an exact root

# what is changed for each mistake, by its id in the catalogue
CHANGES: dict[str, tuple[Change, ...]] = {
    "snell-as-printed": (Change("as_printed ? n2 / n1 : n1 / n2", "n2 / n1"),
                         Change("as_printed ? 1 - sin2 * sin2 : std::max(1 - sin2 * sin2, 0.0)", "1 - sin2 * sin2")),
    "rows-from-the-bottom": (Change("ratio * (-row + scene.height * 0.5)", "ratio * (row - scene.height * 0.5)"),),
    "columns-from-the-right": (Change("ratio * (col - scene.width * 0.5)", "ratio * (scene.width * 0.5 - col)"),),
    "pixel-corners": (Change("camera.ray(scene, row + 0.5, col + 0.5)", "camera.ray(scene, row, col)"),),
    "fov-over-the-shorter-side": (Change("std::max(scene.width, scene.height)", "std::min(scene.width, scene.height)"),),
    "one-pixel-too-few": (Change("std::max(scene.width, scene.height)", "(std::max(scene.width, scene.height) - 1)"),),
    "fov-not-halved": (Change("PI * scene.fov / 360", "PI * scene.fov / 180"),),
    "camera-ray-not-normalised": (Change("normalize(v_x * x + v_y * y + v_dir)", "v_x * x + v_y * y + v_dir"),),
    "root-unrefined": (Change("i < max_iterations", "i < 0"),),
    "one-newton-step": (Change("i < max_iterations", "i < 1"),),
    "normal-not-turned": (statement(TURNED, ";"),),
    "normal-inverted": (statement(TURNED, "if (dot(d, normal) < 0) normal = -normal;"),),
    "normal-not-normalised": (Change("normalize(to_world(surface->normal(to_local(point - center))))",
                                     "to_world(surface->normal(to_local(point - center)))"),),
    "falls-off-squared": (Change(LIGHT, "light.brightness * (cos * intensity / (distance * distance))"),),
    "falls-off": (Change(LIGHT, "light.brightness * (cos * intensity / distance)"),),
    "brightness-squared": (Change(LIGHT, "light.brightness * light.brightness * (cos * intensity)"),),
    "cos-not-clamped": (statement("if (!(cos > 0)) continue;", ";"),),
    "lit-from-behind": (statement("if (!(cos > 0)) continue;", "cos = std::abs(cos);"),),
    "colour-squared": (Change("object.color * illumination", "object.color * object.color * illumination"),),
    "illumination-clamped": (Change("object.color * illumination", "object.color * Vec{std::min(illumination.x, 1.0), "
                                    "std::min(illumination.y, 1.0), std::min(illumination.z, 1.0)}"),),
    "no-shadows": (Change(THROUGH, "1.0"),),
    "shadow-past-the-light": (Change(THROUGH, "light_through(point, shadow_dir, max_distance, sides)"),),
    "transparency-once": (statement("intensity *= objects[k].transparency;",
                                    "if (inside) intensity *= objects[k].transparency;", CROSSED),),
    "glass-casts-full-shadow": (statement("intensity *= objects[k].transparency;", "intensity = 0;", CROSSED),),
    "reflected-short": (Change("d + normal * (2 * cos1)", "d + normal * cos1"),),
    "no-reflection": (Change(MIX, "visible * (1 - R) * (1 - T) + refracted * T"),),
    "no-refraction": (Change(MIX, "(visible * (1 - R) + reflected * R) * (1 - T)"),),
    "reflection-weighs-r": (Change(MIX, "visible * (1 - R) * (1 - T) + reflected * R + refracted * T"),),
    "own-colour-in-full": (Change(MIX, "(visible + reflected * R) * (1 - T) + refracted * T"),),
    "own-colour-beside-t": (Change(MIX, "visible * (1 - R) + reflected * R * (1 - T) + refracted * T"),),
    "weights-subtracted": (Change(MIX, "visible * (1 - R - T) + reflected * R * (1 - T) + refracted * T"),),
    "indices-not-swapped-on-leaving": (Change("sides[hit.index]", "false", "bool leaving = "),),
    "indices-inverted": (Change("sides[hit.index]", "!sides[hit.index]", "bool leaving = "),),
    "never-totally-reflected": (Change("sin1 > n2 / n1", "false"),),
    "total-reflection-lost": (statement(TOTAL, "refracted = Vec{};"),),
    "total-reflection-weighs-r": (statement(TOTAL, TOTAL + " refracted = refracted * (object.reflection / "
                                            "object.transparency);"),),
    "not-refracted": (Change("normalize((d + normal * cos1) * (n1 / n2) - normal * cos2)", "d"),
                      Change("sin1 > n2 / n1", "false")),
    "one-generation-less": (Change("depth > max_depth", "depth >= max_depth"),),
    "one-generation-more": (Change("depth > max_depth", "depth > max_depth + 1"),),
    "one-generation-only": (Change("depth > max_depth", "depth > 1"),),
    "black-at-the-end": (Change("background", "Vec{}", "if (depth > max_depth) return "),),
    "black-background": (Change("background", "Vec{}", "if (hit.index < 0) return "),
                         Change("background", "Vec{}", "if (depth > max_depth) return ")),
    "offset-along-the-normal": (
        Change(REFLECTED, "trace(point + normal * 0.1, reflection_dir, sides, left, depth + 1)"),
        Change(REFRACTED, "trace(point + normal * 0.1, refraction_dir, through, left, depth + 1)"),
        Change(THROUGH, "light_through(point + normal * 0.1, shadow_dir, distance, sides)")),
    "side-from-the-sign": (
        Change("first_hit(o, d, sides, range)", "first_hit(o, d, signs(o), range)"),
        Change(THROUGH, "light_through(point, shadow_dir, distance, signs(point))")),
    "heart-as-printed": (Change("surface->normal(to_local(point - center))",
                                "surface->gradient(to_local(point - center))"),),
    "samples-at-corners": (Change("camera.ray(scene, row + (i + 0.5) / n, col + (j + 0.5) / n)",
                                  "camera.ray(scene, row + i / double(n), col + j / double(n))"),),
    "divided-by-n": (Change("1.0 / (n * n)", "1.0 / n"),),
}
FLAGS = """
#include <cstdlib>
const std::string FLAG_TEXT = std::getenv("FLAG") ? std::getenv("FLAG") : "";
struct { bool operator[](size_t k) const { return k < FLAG_TEXT.size() && FLAG_TEXT[k] == '1'; } } FLAG;

"""
SIGNS = """    Sides signs(Vec o) const {
        Sides found;
        for (const Object& object : objects) found.push_back(object.is_inside(o));
        return found;
    }
"""
# what a scene itself can say: the right port, given another scene
SCENES = {
    "balanced-lights": lambda s: s.traced_with(lights="balanced"),
    "ambient": lambda s: s.traced_with(ambient=0.07),
    "glass-casts-no-shadow": lambda s: s.traced_with(shadows="opaque_only"),
    "range-per-path": lambda s: s.traced_with(range="path"),
    "fixed-axes": lambda s: _camera(s, v_x=(1.0, 0.0, 0.0), v_y=(0.0, 1.0, 0.0)),
    "step-size": lambda s: s.traced_with(step_size=2 * s.tracing.step_size),
    "max-distance": lambda s: s.traced_with(max_distance=s.tracing.max_distance / 2),
    "lights-exchanged": lambda s: s.model_copy(update={"lights": tuple(
        light.model_copy(update={"brightness": other.brightness}) for light, other in zip(s.lights, s.lights[::-1]))}),
    "first-light-only": lambda s: s.model_copy(update={"lights": s.lights[:1]}),
    "last-light-only": lambda s: s.model_copy(update={"lights": s.lights[-1:]}),
    "mean-of-lights": lambda s: s.model_copy(update={"lights": tuple(light.model_copy(update={"brightness": tuple(
        b / len(s.lights) for b in light.brightness)}) for light in s.lights)}),
}


def _srgb(c):
    c = np.clip(c, 0, 1)
    return np.where(c <= 0.0031308, 12.92 * c, 1.055 * np.power(c, 1 / 2.4) - 0.055)


# what is done to the right port's colours on their way into bytes
WRITERS = {
    "gamma": lambda c: rounded(np.power(np.clip(c, 0, 1), 1 / 2.2)),
    "srgb": lambda c: rounded(_srgb(c)),
    "blue-first": lambda c: rounded(c[..., [2, 1, 0]]),
    "truncated": lambda c: (np.clip(c, 0, 1) * 255).astype(np.uint8),
    "times-256": lambda c: np.minimum(np.clip(c, 0, 1) * 256, 255).astype(np.uint8),
    "scaled": lambda c: rounded(0.8 * c),
}


def rounded(color: np.ndarray) -> np.ndarray:
    return np.rint(np.clip(color, 0, 1) * 255).astype(np.uint8)


def _camera(scene: Scene, **changes) -> Scene:
    return scene.model_copy(update={"camera": scene.camera.model_copy(update=changes)})


@cache
def program() -> Path:
    """All wrong ports in one program, compiled once; FLAG says which changes hold. Raises MissingError without a compiler."""
    text = port.SOURCE.read_text()
    for before, more in (("struct Vec {", FLAGS), ("    // --- simulating the collision [4.3] ---", SIGNS)):
        assert text.count(before) == 1
        text = text.replace(before, more + before)
    places: dict[tuple, dict[str, str]] = {}
    for id, changes in CHANGES.items():
        for c in changes:  # statements hold expressions, longer texts hold shorter ones
            places.setdefault((not c.statement, not c.before, -len(c.right), c.before, c.right), {})[id] = c.wrong
    for (expression, _, _, before, right), wrongs in sorted(places.items()):
        assert before + right in text, f"the port has no {before}{right}"
        made = right
        for id, wrong in wrongs.items():
            flag = f"FLAG[{list(CHANGES).index(id)}]"
            made = f"({flag} ? ({wrong}) : ({made}))" if expression else f"if ({flag}) {{ {wrong} }} else {{ {made} }}"
        text = text.replace(before + right, before + made)
    return port.compiled(text)


def color(ids: tuple[str, ...], scene: Scene) -> np.ndarray:
    """What a port with these mistakes, none of them one of a writer, makes of `scene`: (h, w, 3)."""
    for id in ids:
        scene = SCENES[id](scene) if id in SCENES else scene
    made = {"FLAG": "".join("1" if id in ids else "0" for id in CHANGES)}
    with tempfile.TemporaryDirectory() as folder:
        text, raw = Path(folder) / "scene.txt", Path(folder) / "picture.raw"
        text.write_text(plain(scene), encoding="ascii")
        subprocess.run([program(), text, raw, "2"], check=True, capture_output=True, timeout=300, env={**os.environ, **made})
        height, width = scene.camera.height, scene.camera.width
        return np.fromfile(raw, np.float64, 3 * height * width).reshape(height, width, 3)


def written(ids: tuple[str, ...], scene: Scene) -> np.ndarray:
    """The bytes that a port with these mistakes writes: (h, w, 3) uint8."""
    writer = next((WRITERS[id] for id in ids if id in WRITERS), rounded)
    return writer(color(ids, scene))
