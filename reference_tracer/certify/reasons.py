"""Why a proof did not come about: python-flint looks at each undecided ray, and settles what it can."""

from __future__ import annotations

import numpy as np
from flint import ctx

from ..numbers.exact import rational
from ..surfaces.surface import Surface
from ..world import World
from .line import Line, ray_polynomial
from .objects import crossings_of, local_rays
from .origins import starts_along
from .records import NOTHING, SHADOW, unenclosed
from .roots import near_misses
from .verdict import AT_ONCE, NO_DIRECTION, Verdict, decide

PRECISION = 192  # bits of the comparisons
ONE = 1e-13  # relative distance of two crossings that are one within rounding
CLOSE = 1e-6  # two crossings nearer to each other than this nearly touch
SETTLED = ""


def reasons(proofs: World, rows: np.ndarray) -> list[tuple[str, int]]:
    """For every row of undecided rays the reason and the object it lies with, or NOTHING.

    The reason is SETTLED where exact arithmetic decides the ray and confirms the audited method: the object it meets,
    or the light that arrives. Its t has no enclosure there and is not judged.
    """
    if not len(rows):
        return []
    local = local_rays(proofs, rows)
    _, unsure = crossings_of(proofs, rows)
    with ctx.workprec(PRECISION):
        return [_reason(proofs, row, unsure[:, k], local[:, k]) for k, row in enumerate(rows)]


def _reason(world: World, row, unsure, local) -> tuple[str, int]:
    verdict, index = decide(world.scene, row, local), int(row["proven"]["index"])
    if verdict.undecided == NO_DIRECTION:
        return NO_DIRECTION, NOTHING
    if not row["smooth"]:
        return "no gradient where the ray meets the surface", index
    if _is_settled(verdict, row):
        return SETTLED, index
    if row["kind"] != SHADOW and _meets_two(verdict):
        return AT_ONCE, index
    for k in np.flatnonzero(unsure):
        obj = world.scene.objects[k]
        return why(obj.surface, *local[k], verdict.lines[k] if verdict.lines else Line(), row["limit"]), int(k)
    if unenclosed(row.reshape(1))[0]:
        return "the crossing is proven, its distance is not enclosed", index
    return "rounding hides which object comes first", NOTHING


def _is_settled(verdict: Verdict, row) -> bool:
    decided = not verdict.undecided and verdict.wrong_side == NOTHING and not row["audited"]["undecided"]
    return decided and (row["kind"] == SHADOW or len(verdict.hits) < 2) and verdict.agrees(row["audited"], np.inf)


def _meets_two(verdict: Verdict) -> bool:
    """Whether two objects are first crossed within rounding of each other."""
    first = sorted(float(line.first) for line in verdict.lines if line.first is not None)
    return any(b - a < ONE * max(1, a) for a, b in zip(first, first[1:]))


def why(surface: Surface, o, d, line: Line, limit: float) -> str:
    """What is special about the ray o + t d (floats, in the surface's own frame) that does `line`."""
    if starts_along(surface, o, d):
        return "starts along the surface"
    if line.undecided:
        return line.undecided
    if line.touches:
        return "touches without crossing"
    if line.multiple:
        return "crosses at a multiple root"
    gaps = [b - a for a, b in zip(line.crossings, line.crossings[1:])]
    if any(gap < CLOSE for gap in gaps):
        return "two crossings closer than 1e-6"
    if surface.degree is not None and near_misses(ray_polynomial(surface, o, d).p, rational(limit)):
        return "passes within rounding of touching"
    return "rounding hides the sign of f"
