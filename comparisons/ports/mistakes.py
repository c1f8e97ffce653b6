"""The catalogue of classic mistakes: what somebody who writes a port of the document gets wrong, one record each.

A mistake is a name, where the document speaks of it, and when it can show. What a tracer with it computes is written once,
in `mistaken.py`, which traces any set of them together; those of stage "file" are maps of the finished picture.

To add one: a record here, and a line at its stage in `mistaken.py` that asks for its id.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import numpy as np

from raytruth.reference_tracer.scene.model import Scene

Stage = Literal["camera", "hit", "normal", "shading", "shadow", "reflection", "refraction", "mixing", "recursion", "sampling",
                "file"]
Mistakes = dict[str, float]  # ids of mistakes that are made together, each with its amount


def _always(scene: Scene) -> bool:
    return True


@dataclass(frozen=True)
class Mistake:
    """`sentence` says what the program does; `amounts` are those worth trying where a mistake has a size, else (1.0,)."""

    id: str
    sentence: str
    stage: Stage
    section: str
    decision: str  # ids of reference_tracer/DECISIONS.md, "" where the document itself is clear
    matters: Callable[[Scene], bool] = _always
    amounts: tuple[float, ...] = (1.0,)
    fitted: bool = False  # whether the amount may be any number, found by the difference that it makes

    @property
    def measured(self) -> bool:
        """Whether an amount is a quantity; elsewhere it numbers the ways in which programs make the mistake."""
        return self.fitted or self.id in ("step-size", "max-distance", "offset-along-the-ray", "offset-along-the-normal")


# --- when a mistake can show -------------------------------------------------------------------------------------------
def _mirrors(scene: Scene) -> bool:
    return any(o.material.reflection > 0 for o in scene.objects)


def _glass(scene: Scene) -> bool:
    return any(o.material.transparency > 0 for o in scene.objects)


def _refracting(scene: Scene) -> bool:
    return any(o.material.transparency > 0 and o.material.refractive_index != 1 for o in scene.objects)


def _mirrors_and_glass(scene: Scene) -> bool:
    return any(o.material.transparency > 0 and o.material.reflection > 0 for o in scene.objects)


def _secondary(scene: Scene) -> bool:
    return _mirrors(scene) or _glass(scene)


def _lights(scene: Scene) -> bool:
    return len(scene.lights) > 1


def _background(scene: Scene) -> bool:
    return any(scene.background)


def _samples(scene: Scene) -> bool:
    return scene.tracing.samples > 1


def _heart(scene: Scene) -> bool:
    return any(o.surface.type == "heart" for o in scene.objects)


def _turned(scene: Scene) -> bool:
    """Whether the camera's canvas is not along the world's axes."""
    _, v_x, v_y = scene.camera.axes
    return max(abs(a - b) for a, b in zip((*v_x, *v_y), (1, 0, 0, 0, 1, 0))) > 1e-9


def _oblong(scene: Scene) -> bool:
    return scene.camera.width != scene.camera.height


def _unequal_lights(scene: Scene) -> bool:
    return len({light.brightness for light in scene.lights}) > 1


_C, _H, _N, _I, _S = "camera", "hit", "normal", "shading", "shadow"
_R, _T, _M, _D, _P, _F = "reflection", "refraction", "mixing", "recursion", "sampling", "file"

CATALOGUE = {m.id: m for m in (
    # how the figures differ from the text: switches of the scene format
    Mistake("balanced-lights", "several lights are combined as 1 - product of (1 - light) instead of added", _I, "4.3.1",
            "F1 L1", _lights),
    Mistake("ambient", "the illumination starts at a number above 0, an ambient light", _I, "4.3.1", "F2",
            amounts=(0.1, 0.03, 0.3), fitted=True),
    Mistake("glass-casts-no-shadow", "transparent objects cast no shadow", _S, "4.3.1", "F3 L3", _glass),
    Mistake("range-per-path", "the range is shared along a path instead of each ray having its own", _D, "4.1", "F4 M5",
            _secondary),
    Mistake("fixed-axes", "the canvas's axes stay the world's x and y when the camera turns", _C, "2", "F5 C1", _turned),
    Mistake("heart-as-printed", "the heart's normal comes from the printed polynomial, whose gradient vanishes along y = 0: "
            "specks", _N, "7.1.6", "F6 O5", _heart),
    # the file
    Mistake("rows-from-the-bottom", "rows are counted from the bottom (y flipped)", _F, "2", "C1"),
    Mistake("columns-from-the-right", "columns are counted from the right (x flipped)", _F, "2", "C1"),
    Mistake("transposed", "rows and columns are exchanged", _F, "2", "C1"),
    Mistake("gamma", "a gamma of 2.2 was applied", _F, "6", "P1"),
    Mistake("srgb", "the sRGB curve was applied", _F, "6", "P1"),
    Mistake("blue-first", "channels are in the order blue, green, red", _F, "6", "P1"),
    Mistake("truncated", "8-bit values are cut off instead of rounded to the nearest", _F, "6", "P1"),
    Mistake("times-256", "8-bit values are floor(256 c) instead of round(255 c)", _F, "6", "P1"),
    Mistake("clipped", "colours above 1 are clipped in a file that could hold them", _F, "6", "P1"),
    Mistake("wrapped", "8-bit values above 255 wrap around instead of being clamped", _F, "6", "P1"),
    Mistake("scaled", "every colour is multiplied by one factor", _F, "6", "P1", amounts=(0.5, 2.0), fitted=True),
    # camera
    Mistake("pixel-corners", "rays go through the pixels' corners instead of their centres", _C, "2", "C2",
            lambda s: s.tracing.samples == 1),
    Mistake("fov-over-the-shorter-side", "the field of view spans the shorter side instead of the longer one", _C, "2", "C1",
            _oblong),
    Mistake("fov-not-halved", "the tangent is that of the whole field of view, not of half of it", _C, "2", "C1"),
    Mistake("one-pixel-too-few", "the canvas is divided by width - 1 instead of width", _C, "2", "C1"),
    Mistake("camera-ray-not-normalised", "the camera's rays are not normalised", _C, "2", "R4"),
    Mistake("one-sample", "only one sample a pixel is taken", _P, "5", "C2", _samples),
    Mistake("samples-at-corners", "samples lie at i/n of the pixel instead of (i + 0.5)/n", _P, "5", "C2", _samples),
    Mistake("divided-by-n", "the sum of n x n samples is divided by n", _P, "5", "C2", _samples),
    # hits
    Mistake("root-unrefined", "the middle of the step is taken for the root, without Newton's method", _H, "4.2", "M6"),
    Mistake("one-newton-step", "Newton's method ends after one step", _H, "4.2", "M6"),
    Mistake("step-size", "the step size is another one", _H, "4.1", "M2", amounts=(2.0, 0.5)),
    Mistake("max-distance", "rays end at another distance", _H, "4.1", "M5", amounts=(0.5, 0.2, 2.0, 1e3)),
    Mistake("first-in-the-list", "the first object in the list that is hit, or crossed in a step, is shown, not the nearest",
            _H, "4.1", "M4", lambda s: len(s.objects) > 1, amounts=(1.0, 2.0)),
    Mistake("offset-along-the-ray", "secondary and shadow rays start a little along their direction", _D, "4.3", "M3",
            amounts=(1e-3, 1e-2, 1e-1)),
    Mistake("offset-along-the-normal", "secondary and shadow rays start a little along the normal, refracted ones too",
            _D, "4.3", "M3",
            amounts=(1e-3, 1e-2, 1e-1)),
    Mistake("side-from-the-sign", "a secondary ray's side is the sign of f at its origin, which is noise: specks",
            _D, "4.3", "M3",
            amounts=(1.0, 2.0, 3.0, 4.0, 5.0, 6.0)),
    # normals
    Mistake("normal-not-turned", "the normal is not turned against the ray", _N, "4.3", "N1", _glass, amounts=(1.0, 2.0)),
    Mistake("normal-not-normalised", "the gradient is taken for the normal without normalising it", _N, "4.3", "N1"),
    Mistake("normal-inverted", "the normal points along the ray instead of against it", _N, "4.3", "N1", amounts=(1.0, 2.0)),
    # light
    Mistake("falls-off-squared", "light falls off with the square of the distance", _I, "4.3.1", "L1"),
    Mistake("falls-off", "light falls off with the distance", _I, "4.3.1", "L1"),
    Mistake("cos-not-clamped", "light from behind the surface is subtracted: cos(phi) is not clamped at 0", _I, "4.3.1", "L2"),
    Mistake("lit-from-behind", "the absolute value of cos(phi) is taken: light from behind counts", _I, "4.3.1", "L2"),
    Mistake("lights-exchanged", "brightnesses of the lights are exchanged", _I, "4.3.1", "L1", _unequal_lights),
    Mistake("first-light-only", "only the first light shines", _I, "4.3.1", "L1", _lights),
    Mistake("last-light-only", "only the last light shines", _I, "4.3.1", "L1", _lights),
    Mistake("mean-of-lights", "the lights' mean is taken instead of their sum", _I, "4.3.1", "L1", _lights),
    Mistake("illumination-clamped", "the illumination is clamped at 1", _I, "4.3.1", "L1"),
    Mistake("colour-squared", "the object's colour is multiplied in twice", _I, "4.3.1", "L1"),
    Mistake("brightness-squared", "the light's brightness is multiplied in twice", _I, "4.3.1", "L1"),
    # shadows
    Mistake("no-shadows", "there are no shadows", _S, "4.3.1", "L3"),
    Mistake("transparency-once", "a transparent solid dims light by T instead of T x T", _S, "4.3.1", "L3", _glass,
            amounts=(1.0, 2.0)),
    Mistake("glass-casts-full-shadow", "transparent objects cast full shadows", _S, "4.3.1", "L3", _glass),
    Mistake("shadow-past-the-light", "shadow rays do not end at their light", _S, "4.3.1", "M5"),
    # reflection and mixing
    Mistake("no-reflection", "there are no reflection rays", _R, "4.3.2", "", _mirrors),
    Mistake("reflected-short", "the reflected direction is d + n cos instead of d + 2 n cos", _R, "4.3.2", "", _secondary),
    Mistake("reflection-weighs-r", "the reflection's weight is R instead of R (1 - T)", _M, "4.3.4", "", _mirrors_and_glass),
    Mistake("own-colour-in-full", "the point's own colour is not multiplied by 1 - R", _M, "4.3.4", "", _mirrors),
    Mistake("own-colour-beside-t", "the point's own colour is not multiplied by 1 - T", _M, "4.3.4", "", _glass),
    Mistake("weights-subtracted", "the point's own weight is 1 - R - T instead of (1 - R) (1 - T)", _M, "4.3.4", "",
            _mirrors_and_glass),
    # refraction
    Mistake("snell-as-printed", "the law of refraction as misprinted: sin2 = sin1 n2 / n1", _T, "4.3.3.2", "E1", _refracting,
            amounts=(1.0, 2.0)),  # its directions of NaN meet nothing, or what the literal steps make of them
    Mistake("indices-inverted", "n1 and n2 are exchanged", _T, "4.3.3", "R1", _refracting),
    Mistake("indices-not-swapped-on-leaving", "a ray that leaves an object is refracted as one that enters", _T, "4.3.3", "R1",
            _refracting),
    Mistake("not-refracted", "rays go straight through transparent objects", _T, "4.3.3", "R1", _refracting),
    Mistake("no-refraction", "there are no refraction rays", _T, "4.3.3", "", _glass),
    Mistake("never-totally-reflected", "total reflection is left out: the ray leaves along the surface", _T, "4.3.3.1", "R3",
            _refracting),
    Mistake("total-reflection-lost", "a totally reflected ray returns nothing", _T, "4.3.3.1", "R3", _refracting),
    Mistake("total-reflection-weighs-r", "a totally reflected ray has the weight R instead of T", _T, "4.3.3.1", "R3",
            _refracting),
    # recursion and background
    Mistake("one-generation-less", "recursion ends one generation early", _D, "4.3", "D1", _secondary),
    Mistake("one-generation-more", "recursion ends one generation late", _D, "4.3", "D1", _secondary),
    Mistake("one-generation-only", "secondary rays have no secondary rays", _D, "4.3", "D1", _secondary),
    Mistake("black-at-the-end", "rays beyond the last generation return black instead of the background", _D, "4.3", "D1",
            lambda s: _secondary(s) and _background(s)),
    Mistake("black-background", "the background is black", _D, "4.3", "D2", _background),
)}
SWITCHES = ("balanced-lights", "ambient", "glass-casts-no-shadow", "range-per-path", "fixed-axes", "heart-as-printed")
NOISY = ("side-from-the-sign",)  # their pattern is rounding's: each amount is another draw of it


def possible(scene: Scene) -> dict[str, Mistake]:
    """The mistakes that can show in a picture of `scene`."""
    return {id: m for id, m in CATALOGUE.items() if m.matters(scene)}


# --- maps of the finished picture --------------------------------------------------------------------------------------
def filed(mistakes: Mistakes, color: np.ndarray, levels: int | None) -> np.ndarray:
    """Colours (..., 3) as a program with these mistakes writes them, those that move no pixel; `levels` as in `quantised`.

    A file of whole numbers holds only what is within [0, 1].
    """
    if "scaled" in mistakes:
        color = color * mistakes["scaled"]
    if "clipped" in mistakes or (levels and "wrapped" not in mistakes):
        color = np.clip(color, 0, 1)
    if "gamma" in mistakes:
        color = np.clip(color, 0, None) ** (1 / 2.2)
    if "srgb" in mistakes:
        c = np.clip(color, 0, None)
        color = np.where(c <= 0.0031308, 12.92 * c, 1.055 * c ** (1 / 2.4) - 0.055)
    if levels:
        if "truncated" in mistakes:
            color = np.floor(color * levels + 1e-9) / levels
        if "times-256" in mistakes:
            color = np.minimum(np.floor(color * (levels + 1) + 1e-9), levels) / levels
        if "wrapped" in mistakes:
            color = np.floor(color * levels + 0.5) % (levels + 1) / levels
    return color[..., ::-1] if "blue-first" in mistakes else color


def moved(mistakes: Mistakes, rows: np.ndarray, columns: np.ndarray, height: int, width: int) -> tuple[np.ndarray, np.ndarray]:
    """Which pixel of the right picture stands at each of these places of the file."""
    if "transposed" in mistakes:
        rows, columns = columns, rows
    if "rows-from-the-bottom" in mistakes:
        rows = height - 1 - rows
    if "columns-from-the-right" in mistakes:
        columns = width - 1 - columns
    return rows, columns
