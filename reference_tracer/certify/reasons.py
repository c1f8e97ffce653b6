"""Why a proof did not come about: python-flint looks at each undecided ray."""

from __future__ import annotations

import numpy as np
from flint import ctx

from ..numbers import Dual
from ..numbers.exact import rational
from ..surfaces.surface import Surface
from ..world import World
from .line import follow, ray_polynomial
from .objects import crossings_of, local_rays
from .records import is_inside, tied, unenclosed
from .roots import near_misses

CLOSE = 1e-6  # two crossings nearer to each other than this nearly touch
GRAZING = 1e-6  # sine of the angle between a ray and the surface it starts on


def reasons(proofs: World, rows: np.ndarray) -> list[tuple[str, int]]:
    """For every row of undecided rays the reason and the object it lies with (-1: no single one)."""
    if not len(rows):
        return []
    local = local_rays(proofs, rows)
    _, unsure = crossings_of(proofs, rows)
    return [_reason(proofs, row, unsure[:, k], local[:, k]) for k, row in enumerate(rows)]


def _reason(world: World, row, unsure, local) -> tuple[str, int]:
    row_alone = row.reshape(1)
    for index in np.flatnonzero(unsure):
        inside = bool(is_inside(row_alone, index)[0])
        o, d = local[index]
        return why(world.scene.objects[index].surface, o, d, inside, row["limit"]), int(index)
    index = int(row["proven"]["index"])
    if not row["smooth"]:
        return "no gradient where the ray meets the surface", index
    if tied(row_alone)[0]:
        return "two surfaces at one distance", index
    if unenclosed(row_alone)[0]:
        return "the crossing is proven, its distance is not enclosed", index
    return "undecided only in the company of other objects", -1


def why(surface: Surface, o, d, inside: bool, limit: float) -> str:
    """What is special about the ray o + t d (floats, in the surface's own frame)."""
    if starts_along(surface, o, d):
        return "starts along the surface"
    line = follow(surface, o, d, inside, limit)
    if line.undecided:
        return line.undecided
    if line.touches:
        return "touches without crossing"
    if line.multiple:
        return "crosses at a multiple root"
    with ctx.workprec(192):
        gaps = [b - a for a, b in zip(line.crossings, line.crossings[1:])]
        if any(gap < CLOSE for gap in gaps):
            return "two crossings closer than 1e-6"
        if surface.degree is not None and near_misses(ray_polynomial(surface, o, d).p, rational(limit)):
            return "passes within rounding of touching"
    return "rounding hides the sign of f"


def starts_along(surface: Surface, o, d) -> bool:
    """Whether the ray starts on the surface and nearly in its tangent plane."""
    value, gradient = _slope(surface, o)
    steepness = np.linalg.norm(gradient)
    return bool(distance_estimate(surface, o) < 1e-9 and abs(gradient @ d) < GRAZING * steepness)


def distance_estimate(surface: Surface, point) -> float:
    """|f| / |grad f| over the size of the coordinates: small where `point` lies on the surface but for rounding."""
    value, gradient = _slope(surface, point)
    with np.errstate(all="ignore"):
        return float(abs(value) / np.linalg.norm(gradient) / (1 + np.abs(point).max()))


def _slope(surface: Surface, point) -> tuple[float, np.ndarray]:
    with np.errstate(all="ignore"):
        g = surface.regular(*Dual.axes(tuple(np.float64(c) for c in point)))
        return float(g.value), np.array([float(g.derivative(k)) for k in range(3)])
