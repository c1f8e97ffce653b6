"""Ports that make one classic mistake each: passages of the C++ and the NumPy port, and what stands there in a wrong one.

`CPP` and `NUMPY` name each mistake: the passage as it is, which stands in the source once, the wrong one, and the ids of the
catalogue (comparisons/ports/mistakes.py) by which it is named right. Several ids where they show the same.
"""

from __future__ import annotations

from pathlib import Path

HERE = Path(__file__).parent
CPP_SOURCE, NUMPY_SOURCE = HERE / "cpp" / "tracer.cpp", HERE / "numpy" / "tracer.py"


def wrong(source: Path, passage: str, instead: str) -> str:
    """The source with the mistake."""
    text = source.read_text(encoding="utf-8")
    if text.count(passage) != 1:
        raise ValueError(f"{source.name} has {text.count(passage)} passages {passage!r}")
    return text.replace(passage, instead)


CPP = {
    "y flipped": ("ratio * (-row + scene.height * 0.5)", "ratio * (row - scene.height * 0.5)", ("rows-from-the-bottom",)),
    "x flipped": ("ratio * (col - scene.width * 0.5)", "-ratio * (col - scene.width * 0.5)", ("columns-from-the-right",)),
    "pixel corners": ("Vec d = camera.ray(scene, row + 0.5, col + 0.5);", "Vec d = camera.ray(scene, row, col);", ("pixel-corners",)),
    "FOV over the wrong side": ("std::max(scene.width, scene.height);", "std::min(scene.width, scene.height);",
                                ("fov-over-the-shorter-side",)),
    "FOV not halved": ("2 * std::tan(PI * scene.fov / 360)", "2 * std::tan(PI * scene.fov / 180)", ("fov-not-halved",)),
    "camera ray not normalised": ("return normalize(v_x * x + v_y * y + v_dir);", "return v_x * x + v_y * y + v_dir;",
                                  ("camera-ray-not-normalised",)),
    "samples at corners": ("row + (i + 0.5) / n, col + (j + 0.5) / n", "row + i * 1.0 / n, col + j * 1.0 / n",
                           ("samples-at-corners",)),
    "gamma applied": ("picture.color[pixel] = sum * (1.0 / (n * n));",
                      "Vec mean = sum * (1.0 / (n * n));\n        picture.color[pixel] = "
                      "{std::pow(mean.x, 1 / 2.2), std::pow(mean.y, 1 / 2.2), std::pow(mean.z, 1 / 2.2)};", ("gamma", "srgb")),
    "8-bit rounding": ("picture.color[pixel] = sum * (1.0 / (n * n));",
                       "Vec mean = sum * (255.0 / (n * n));\n        picture.color[pixel] = Vec{std::round(mean.x), "
                       "std::round(mean.y), std::round(mean.z)} * (1 / 255.0);", ("eight-bits", "truncated", "rounded")),
    "fp32 where fp64 is claimed": ("        t -= dt;\n", "        t = static_cast<float>(t - dt);\n", ("single-precision",)),
    "one Newton step": ("            t -= dt;\n", "            t -= dt;\n            break;\n", ("one-newton-step",)),
    "no Newton": ("        for (int i = 0; i < max_iterations; i++) {\n            Vec point",
                  "        for (int i = 0; i < 0; i++) {\n            Vec point", ("root-unrefined",)),
    "first object of the list": ("if (root < hit.t) hit = {root, static_cast<int>(k), t};  // refine",
                                 "if (hit.index < 0) hit = {root, static_cast<int>(k), t};  // refine", ("first-in-the-list",)),
    "range of half": ("double left = shared_range ?", "double left = true ?", ("range-per-path",)),
    "balanced lights": ("illumination = balanced ?", "illumination = true ?", ("balanced-lights",)),
    "ambient": ("Vec illumination{ambient, ambient, ambient};", "Vec illumination{0.1, 0.1, 0.1};", ("ambient",)),
    "glass without shadows": ("(opaque_only && objects[k].transparency > 0)) continue;  // F3",
                              "(objects[k].transparency > 0)) continue;  // F3",
                              ("glass-casts-no-shadow",)),
    "no shadows": ("double intensity = light_through(point, shadow_dir, distance, sides);", "double intensity = 1;", ("no-shadows",)),
    "T in place of T^2": ("intensity *= objects[k].transparency;  // at every crossing (L3)",
                          "if (inside) intensity *= objects[k].transparency;", ("transparency-once",)),
    "full shadow of glass": ("intensity *= objects[k].transparency;  // at every crossing (L3)", "intensity = 0;",
                             ("glass-casts-full-shadow",)),
    "light falls off": ("Vec more = light.brightness * (cos * intensity), one{1, 1, 1};",
                        "Vec more = light.brightness * (cos * intensity / (distance * distance)), one{1, 1, 1};",
                        ("falls-off-squared",)),
    "normal not turned": ("        if (dot(d, normal) > 0) normal = -normal;  // turned against the ray (N1)\n"
                          "        double cos1 = std::min(-dot(d, normal), 1.0);", "        double cos1 = std::min(-dot(d, normal), 1.0);",
                          ("normal-not-turned",)),
    "normal not normalised": ("Vec normal(Vec point) const { return normalize(to_world(surface->normal(to_local(point - center)))); }",
                              "Vec normal(Vec point) const { return to_world(surface->normal(to_local(point - center))); }",
                              ("normal-not-normalised",)),
    "misprint": ("double sin2 = sin1 * (as_printed ? n2 / n1 : n1 / n2);", "double sin2 = sin1 * n2 / n1;", ("snell-as-printed",)),
    "n1 and n2 exchanged": ("double n1 = leaving ? object.refractive_index : 1, n2 = leaving ? 1 : object.refractive_index;",
                            "double n2 = leaving ? object.refractive_index : 1, n1 = leaving ? 1 : object.refractive_index;",
                            ("indices-inverted",)),
    "n1 and n2 not swapped on leaving": ("bool leaving = sides[hit.index];", "bool leaving = false;",
                                         ("indices-not-swapped-on-leaving",)),
    "weight of total reflection": ("refracted = object.reflection > 0 ? reflected : trace(point, reflection_dir, sides, left, depth + 1);",
                                   "refracted = (object.reflection > 0 ? reflected : trace(point, reflection_dir, sides, left, depth + 1))"
                                   " * (object.reflection / object.transparency);", ("total-reflection-weighs-r",)),
    "total reflection lost": ("if (sin1 > n2 / n1) {", "if (sin1 > n2 / n1) {\n            } else if (false) {",
                              ("total-reflection-lost",)),
    "reflected short": ("normalize(d + normal * (2 * cos1))", "normalize(d + normal * cos1)", ("reflected-short",)),
    "depth off by one": ("if (depth > max_depth) return background;", "if (depth >= max_depth) return background;",
                         ("one-generation-less",)),
}

NUMPY = {
    # along the ray it would show nothing: the sides are inherited, and the line is the same
    "epsilon offset": ("return trace(scene, point[which], unit(direction[which])",
                       "return trace(scene, point[which] + 1e-3 * normal[which], unit(direction[which])",
                       ("offset-along-the-normal", "offset-along-the-ray")),
    "no renormalisation": ("unit(direction[which])", "direction[which] * (1 + 1e-6)", ()),
    "one generation more": ("if depth == scene.max_depth:", "if depth == scene.max_depth + 1:", ("one-generation-more",)),
    "printed normal of the heart": ('if self.kind != "heart":', "if True:", ("heart-as-printed",)),
    "mean of the lights": ("illumination[lit] += more", "illumination[lit] += more / len(scene.lights)", ("mean-of-lights",)),
    "light from behind": ("lit = cos[:, 0] > 0", "cos = np.abs(cos)\n        lit = cos[:, 0] > 0", ("lit-from-behind",)),
    "own colour in full": ("(visible * (1 - obj.R) + reflected * obj.R)", "(visible + reflected * obj.R)", ("own-colour-in-full",)),
    "divided by n": (".mean(axis=1)", ".sum(axis=1) / n", ("divided-by-n",)),
    "blue first": ('"color": (color, "float64")', '"color": (color[:, ::-1], "float64")', ("blue-first",)),
    "never totally reflected": ("total = (sin1 > n2 / n1)[:, 0]", "total = (sin1 > np.inf)[:, 0]", ("never-totally-reflected",)),
}
