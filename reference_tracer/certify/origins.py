"""Where a ray starts in relation to a surface, as far as floats tell."""

from __future__ import annotations

import math

import numpy as np

from ..numbers import Dual
from ..surfaces.surface import Surface

ON_SURFACE = 1e-9  # relative distance from a surface that rounding explains
GRAZING = 1e-6  # sine of the angle between a ray and the surface it starts on


def starts_on(surface: Surface, o) -> bool:
    """Whether `o` (the surface's own frame) lies on the surface but for rounding: |f| / |grad f| is tiny."""
    value, gradient = _linear(surface, o)
    with np.errstate(all="ignore"):
        return bool(abs(value) <= ON_SURFACE * (1 + np.abs(o).max()) * math.hypot(*gradient))


def starts_along(surface: Surface, o, d) -> bool:
    """Whether the ray starts on the surface and nearly in its tangent plane."""
    _, gradient = _linear(surface, o)
    return starts_on(surface, o) and bool(abs(gradient @ d) < GRAZING * math.hypot(*gradient))


def _linear(surface: Surface, point) -> tuple[float, np.ndarray]:
    """f and grad f of the regular form."""
    with np.errstate(all="ignore"):
        g = surface.regular(*Dual.axes(tuple(np.float64(c) for c in point)))
        return float(g.value), np.array([float(g.derivative(k)) for k in range(3)])
