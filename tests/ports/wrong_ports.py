"""Ports that are wrong on purpose: the C++ and the NumPy port, with one classic mistake each or several.

The text of the C++ port is changed at one place a mistake; all changes are compiled into one program, and the environment
chooses which hold. It shares no code with comparisons/ports/mistaken.py, which has to recognise what it shows.

How many check-port fails, and how many it names right; of all cases in an hour:

    python tests/ports/wrong_ports.py [NAME ...] [--only CASES ...]
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np

from raytruth.arguments import Parser
from raytruth.comparisons.bench import port
from raytruth.comparisons.ports import check
from raytruth.comparisons.ports.cases import chosen
from raytruth.comparisons.ports.mistakes import SWITCHES
from raytruth.comparisons.ports.session import Port
from raytruth.comparisons.ports.truth import Truths
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
    "balanced-lights": (Change("balanced", "true", "illumination = "),),
    "ambient": (Change("ambient", "0.07", "Vec illumination = Vec{1, 1, 1} * "),),
    "glass-casts-no-shadow": (Change("opaque_only", "true", "!objects[k].shadow || ("),),
    "range-per-path": (Change("shared_range", "true", "double left = "),),
    "fixed-axes": (Change("cross(scene.up, v_dir)", "Vec{1, 0, 0}"), Change("cross(v_dir, v_x)", "Vec{0, 1, 0}")),
    "first-in-the-list": (statement("if (root < hit.t) hit = {root, static_cast<int>(k), t};",
                                    "if (hit.index < 0) hit = {root, static_cast<int>(k), t};"),),
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
STORED = "picture.color[pixel] = sum * (1.0 / (n * n));"
MEAN = "Vec mean = sum * (1.0 / (n * n)); picture.color[pixel] = Vec{%s(mean.x%s), %s(mean.y%s), %s(mean.z%s)} * %s;"
# what a file of 8 bits does not tell, or does anyway
OF_ANSWERS = {
    "gamma": (statement(STORED, MEAN % (*("std::pow", ", 1 / 2.2") * 3, "1")),),
    "eight-bits": (statement(STORED, MEAN % (*("std::round", " * 255") * 3, "(1 / 255.0)")),),
    "single-precision": (statement("t -= dt;", "t = static_cast<float>(t - dt);"),),
}
IDS = (*CHANGES, *OF_ANSWERS)  # in the order of their flags
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


@cache
def program() -> Path:
    """All wrong ports in one program, compiled once; FLAG says which changes hold. Raises MissingError without a compiler."""
    text = port.SOURCE.read_text()
    for before, more in (("struct Vec {", FLAGS), ("    // --- simulating the collision [4.3] ---", SIGNS)):
        assert text.count(before) == 1
        text = text.replace(before, more + before)
    places: dict[tuple, dict[str, str]] = {}
    for id, changes in {**CHANGES, **OF_ANSWERS}.items():
        for c in changes:  # statements hold expressions, longer texts hold shorter ones
            places.setdefault((not c.statement, not c.before, -len(c.right), c.before, c.right), {})[id] = c.wrong
    for (expression, _, _, before, right), wrongs in sorted(places.items()):
        assert before + right in text, f"the port has no {before}{right}"
        made = right
        for id, wrong in wrongs.items():
            flag = f"FLAG[{IDS.index(id)}]"
            made = f"({flag} ? ({wrong}) : ({made}))" if expression else f"if ({flag}) {{ {wrong} }} else {{ {made} }}"
        text = text.replace(before + right, before + made)
    return port.compiled(text)


def _flags(ids: Sequence[str]) -> str:
    return "".join("1" if id in ids else "0" for id in IDS)


def serving(*ids: str) -> list[str]:
    """The command of a C++ port with these mistakes that speaks the protocol. Raises MissingError without a compiler."""
    return ["env", f"FLAG={_flags(ids)}", str(program()), "--serve"]


def color(ids: tuple[str, ...], scene: Scene) -> np.ndarray:
    """What a port with these mistakes, none of them one of a writer, makes of `scene`: (h, w, 3)."""
    for id in ids:
        scene = SCENES[id](scene) if id in SCENES else scene
    made = {"FLAG": _flags(ids)}
    with tempfile.TemporaryDirectory() as folder:
        text, raw = Path(folder) / "scene.txt", Path(folder) / "picture.raw"
        text.write_text(plain(scene), encoding="ascii")
        subprocess.run([program(), text, raw, "2"], check=True, capture_output=True, timeout=300, env={**os.environ, **made})
        height, width = scene.camera.height, scene.camera.width
        return np.fromfile(raw, np.float64, 3 * height * width).reshape(height, width, 3)


def written(ids: tuple[str, ...], scene: Scene) -> np.ndarray:
    """The bytes that a port with these mistakes writes: (h, w, 3) uint8."""
    writer = next((WRITERS[id] for id in ids if id in WRITERS), rounded)
    return writer(color(tuple(id for id in ids if id not in WRITERS), scene))


# --- the NumPy port --------------------------------------------------------------------------------------------------------
NUMPY_SOURCE = Path(__file__).parent / "numpy" / "tracer.py"
# a passage of the source, what stands there in a wrong one, and the mistake's id; None where it is none of the catalogue
NUMPY = {
    # along the ray it would show nothing: the sides are inherited, and the line is the same
    "epsilon offset": ("return trace(scene, point[which], unit(direction[which])",
                       "return trace(scene, point[which] + 1e-3 * normal[which], unit(direction[which])",
                       "offset-along-the-normal"),
    "no renormalisation": ("unit(direction[which])", "direction[which] * (1 + 1e-6)", None),
    "one generation more": ("if depth == scene.max_depth:", "if depth == scene.max_depth + 1:", "one-generation-more"),
    "printed normal of the heart": ('if self.kind != "heart":', "if True:", "heart-as-printed"),
    "mean of the lights": ("illumination[lit] += more", "illumination[lit] += more / len(scene.lights)", "mean-of-lights"),
    "light from behind": ("lit = cos[:, 0] > 0", "cos = np.abs(cos)\n        lit = cos[:, 0] > 0", "lit-from-behind"),
    "own colour in full": ("(visible * (1 - obj.R) + reflected * obj.R)", "(visible + reflected * obj.R)", "own-colour-in-full"),
    "divided by n": (".mean(axis=1)", ".sum(axis=1) / n", "divided-by-n"),
    "blue first": ('"color": (color, "float64")', '"color": (color[:, ::-1], "float64")', "blue-first"),
    "never totally reflected": ("total = (sin1 > n2 / n1)[:, 0]", "total = (sin1 > np.inf)[:, 0]", "never-totally-reflected"),
}


def wrong_numpy(name: str, folder: Path) -> list[str]:
    """The command of the NumPy port with a mistake."""
    passage, instead, _ = NUMPY[name]
    text = NUMPY_SOURCE.read_text(encoding="utf-8")
    if text.count(passage) != 1:
        raise ValueError(f"the NumPy port has {text.count(passage)} passages {passage!r}")
    (folder / "wrong.py").write_text(text.replace(passage, instead), encoding="utf-8")
    return [sys.executable, str(folder / "wrong.py")]


# --- how many are failed, and named ----------------------------------------------------------------------------------------
def all_of_them(folder: Path) -> Iterator[tuple[str, list[str], set[str]]]:
    """What each is called, its command, and all that it should be named."""
    for id in IDS:
        yield id, serving(id), {id}
    for name, (_, _, id) in NUMPY.items():
        yield f"NumPy: {name}", wrong_numpy(name, folder), {id} if id else set()
    yield "as the figures", serving(*SWITCHES), set(SWITCHES)


def main() -> None:
    parser = Parser(description="How many wrong ports check-port fails, and how many it names right.")
    parser.add_argument("names", nargs="*", metavar="NAME", help="a mistake, as the output names it (default all)")
    parser.add_argument("--only", nargs="+", default=["algorithm:"], metavar="CASES", help="as check-port understands it")
    arguments, truths, counts = parser.parse_args(), Truths(Path("results")), Counter()
    cases = chosen(arguments.only)
    with tempfile.TemporaryDirectory() as folder:
        for name, command, ids in all_of_them(Path(folder)):
            if arguments.names and name not in arguments.names:
                continue
            with Port(command) as process:
                kept: list[check.Failed] = []
                check.check(process, process.greet(60), cases, truths, 600, kept=kept)
            start = time.process_time()
            found = [cause.id for cause in check.likely(kept, 64, truths)]
            counts.update(asked=1, failed=int(bool(kept)), all=int(set(found) == ids),
                          first=int(set(found[:1]) <= ids and bool(found) == bool(ids)))
            print(f"{name:<32} {len(kept):3} cases fail, {time.process_time() - start:5.1f} s: {', '.join(found) or 'nothing named'}",
                  flush=True)
    print(f"{counts['failed']} of {counts['asked']} fail; named first {counts['first']}, named and nothing else {counts['all']}")


if __name__ == "__main__":
    main()
