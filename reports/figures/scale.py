"""The one error scale of the whole report: a decade is the same colour in every map of every scene."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

LOW, HIGH = 1e-9, 1.0
DECADES = 9
LEVELS = 256
STEP = 10 ** (DECADES / (LEVELS - 1))  # ratio of two neighbouring levels' errors: 1.085


def from_oklch(lightness, chroma, hue) -> np.ndarray:
    """OKLCH (0..1, about 0..0.3, degrees) to 8-bit sRGB, shape (..., 3).

    OKLab: Björn Ottosson, "A perceptual color space for image processing", 2020. Out-of-gamut values are clipped.
    """
    lightness, chroma, angle = (np.asarray(v, float) for v in (lightness, chroma, np.deg2rad(hue)))
    a, b = chroma * np.cos(angle), chroma * np.sin(angle)
    long, middle, short = (lightness + 0.3963377774 * a + 0.2158037573 * b,
               lightness - 0.1055613458 * a - 0.0638541728 * b,
               lightness - 0.0894841775 * a - 1.2914855480 * b)
    long, middle, short = long**3, middle**3, short**3
    linear = np.stack([4.0767416621 * long - 3.3077115913 * middle + 0.2309699292 * short,
                       -1.2684380046 * long + 2.6097574011 * middle - 0.3413193965 * short,
                       -0.0041960863 * long - 0.7034186147 * middle + 1.7076147010 * short], axis=-1)
    linear = np.clip(linear, 0, 1)
    encoded = np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)
    return np.floor(encoded * 255 + 0.5).astype(np.uint8)


def css(colour) -> str:
    """(r, g, b) in 0..255 as #rrggbb."""
    return "#" + "".join(f"{int(c):02x}" for c in colour)


# Colours outside the scale, distinguished by lightness alone: black, dark blue, cyan, white.
EXACT = np.array([0, 0, 0], np.uint8)
UNDECIDED = np.array([47, 107, 255], np.uint8)
MISMATCH = np.array([0, 224, 255], np.uint8)
NON_FINITE = np.array([255, 255, 255], np.uint8)


def _table() -> np.ndarray:
    """(LEVELS, 3) uint8: lightness rises evenly, hue runs from violet over red to yellow."""
    anchors = np.linspace(0, 1, 6)
    at = np.linspace(0, 1, LEVELS)
    chroma = np.interp(at, anchors, [0.135, 0.175, 0.180, 0.180, 0.165, 0.160])
    hue = np.interp(at, anchors, [292, 318, 358, 396, 424, 457])
    return from_oklch(0.27 + 0.63 * at, chroma, hue)


TABLE = _table()


def level(error) -> np.ndarray:
    """The nearest of the LEVELS steps of the logarithmic scale; what lies outside [LOW, HIGH] takes its end."""
    position = np.log10(np.clip(error, LOW, HIGH) / LOW) / DECADES
    return np.floor(position * (LEVELS - 1) + 0.5).astype(np.intp)


def error_of(levels) -> np.ndarray:
    """The error a level stands for; it is within a factor sqrt(STEP) of every error shown with that level."""
    return LOW * STEP ** np.asarray(levels, float)


def paint(error: np.ndarray, mismatch: np.ndarray, undecided: np.ndarray) -> np.ndarray:
    """An error map, (h, w, 3) uint8, of (h, w) errors >= 0 (NaN: not finite in one of the pictures).

    What cannot be measured outranks what can: not finite, then undecided, then another object, then the error.
    """
    finite = np.isfinite(error)
    pixels = np.empty((*error.shape, 3), np.uint8)
    pixels[:] = EXACT
    differs = finite & (error != 0)  # most pixels are equal and need no logarithm
    pixels[differs] = TABLE[level(error[differs])]
    pixels[mismatch] = MISMATCH
    pixels[undecided] = UNDECIDED
    pixels[~finite] = NON_FINITE
    return pixels


@dataclass(frozen=True)
class Swatch:
    name: str
    colour: str
    means: str


EQUAL = Swatch("equal", css(EXACT), "both pictures have exactly the same number, or neither hits anything")
SPECIAL = (
    Swatch("another object", css(MISMATCH),
           "the ray through the pixel’s centre hits another object, or hits in one picture only"),
    Swatch("undecided", css(UNDECIDED), "at least one picture says that it cannot decide a ray of this pixel"),
    Swatch("not finite", css(NON_FINITE), "at least one picture is NaN or infinite"),
)


@dataclass(frozen=True)
class Tick:
    at: float  # percent of the scale's length
    exponent: int
    major: bool


TICKS = tuple(Tick(100 * k / DECADES, k - DECADES, k % 3 == 0) for k in range(DECADES + 1))
