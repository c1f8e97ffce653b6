"""Why a proof did not come about: python-flint looks at each undecided ray, and settles what it can."""

from __future__ import annotations

import numpy as np
from flint import ctx

from ..numbers.exact import rational
from ..surfaces.surface import Surface
from ..tracer.world import World
from .audit import Blame, audited_fault
from .line import Line, ray_polynomial
from .objects import crossings_of, local_rays
from .origins import starts_along
from .records import NOTHING, unenclosed
from .roots import near_misses
from .verdict import AT_ONCE, NO_DIRECTION, decide

PRECISION = 192  # bits of the comparisons
CLOSE = 1e-6  # two crossings nearer to each other than this are told as the reason; no verdict hangs on it
SETTLED = ""


def reasons(proofs: World, rows: np.ndarray, blame: Blame) -> list[tuple[str, int]]:
    """For every row of undecided rays the reason and the object it lies with, or NOTHING.

    The reason is SETTLED where exact arithmetic decides the ray and the audited method vouches for its own answer: that
    is confirmed, the object it meets and about where, or the light that arrives; or `blame` is called.
    """
    if not len(rows):
        return []
    local = local_rays(proofs, rows)
    _, unsure = crossings_of(proofs, rows)
    with ctx.workprec(PRECISION):
        return [_reason(proofs, row, unsure[:, k], local[:, k], blame) for k, row in enumerate(rows)]


def _reason(world: World, row, unsure, local, blame: Blame) -> tuple[str, int]:
    verdict, index = decide(world.scene, row, local), int(row["proven"]["index"])
    if verdict.undecided == NO_DIRECTION:
        return NO_DIRECTION, NOTHING
    if not row["smooth"]:
        return "no gradient where the ray meets the surface", index
    if verdict.wrong_side != NOTHING:
        blame("wrong side", row, verdict.wrong_side, "f at the origin has the other sign")
        return SETTLED, verdict.wrong_side
    claimed = not verdict.undecided and not row["audited"]["undecided"]
    if claimed and (fault := audited_fault(verdict, row, proven=False)):
        blame(fault, row, next(iter(verdict.hits or {}), index), f"exact: {verdict}")
    if verdict.tied:
        return AT_ONCE, index
    if claimed:
        return SETTLED, index
    for k in np.flatnonzero(unsure):
        obj = world.scene.objects[k]
        return why(obj.surface, *local[k], verdict.lines[k] if verdict.lines else Line(), row["limit"]), int(k)
    if unenclosed(row.reshape(1))[0]:
        return "the crossing is proven, its distance is not enclosed", index
    return "rounding hides which object comes first", NOTHING


def why(surface: Surface, o, d, line: Line, limit: float) -> str:
    """What is special about the ray o + t d (floats, in the surface's own frame) that does `line`."""
    if starts_along(surface, o, d):
        return "starts along the surface, or where its gradient vanishes"
    if line.undecided:
        return line.undecided
    if line.touches:
        return "touches without crossing"
    if line.multiple:
        return "crosses at a multiple root"
    gaps = [b - a for a, b in zip(line.crossings, line.crossings[1:])]
    if any(gap < CLOSE for gap in gaps):
        return "two crossings closer than 1e-6"
    if surface.exact_form is not None and near_misses(ray_polynomial(surface, o, d).p, rational(limit)):
        return "passes within rounding of touching"
    return "rounding hides the sign of f"
