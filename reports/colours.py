"""Colours by lightness, chroma and hue, so that equal steps look equal."""

from __future__ import annotations

import numpy as np


def from_oklch(lightness, chroma, hue) -> np.ndarray:
    """OKLCH (0..1, about 0..0.3, degrees) to 8-bit sRGB, shape (..., 3).

    OKLab: Björn Ottosson, "A perceptual color space for image processing", 2020. Out-of-gamut values are clipped.
    """
    lightness, chroma, angle = (np.asarray(v, float) for v in (lightness, chroma, np.deg2rad(hue)))
    a, b = chroma * np.cos(angle), chroma * np.sin(angle)
    l, m, s = (lightness + 0.3963377774 * a + 0.2158037573 * b,
               lightness - 0.1055613458 * a - 0.0638541728 * b,
               lightness - 0.0894841775 * a - 1.2914855480 * b)
    l, m, s = l**3, m**3, s**3
    linear = np.stack([4.0767416621 * l - 3.3077115913 * m + 0.2309699292 * s,
                       -1.2684380046 * l + 2.6097574011 * m - 0.3413193965 * s,
                       -0.0041960863 * l - 0.7034186147 * m + 1.7076147010 * s], axis=-1)
    linear = np.clip(linear, 0, 1)
    encoded = np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)
    return np.floor(encoded * 255 + 0.5).astype(np.uint8)


def css(colour) -> str:
    """(r, g, b) in 0..255 as #rrggbb."""
    return "#" + "".join(f"{int(c):02x}" for c in colour)
