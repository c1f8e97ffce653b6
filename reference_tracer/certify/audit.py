"""The audit: python-flint decides sampled rays on its own, and both methods' claims are held against it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from flint import arb, ctx

from ..numbers.exact import rational
from ..world import World
from .certificate import Audit
from .line import Line, follow
from .objects import local_rays
from .reasons import distance_estimate
from .records import KINDS, NOTHING, SHADOW, is_inside

PRECISION = 192  # bits of the comparisons
ON_SURFACE = 1e-9  # relative distance from a surface that rounding explains


@dataclass
class Verdict:
    """The exact answer to one ray."""

    undecided: str = ""
    wrong_side: int = NOTHING  # an object whose side the ray claims wrongly
    touches: bool = False
    hits: dict[int, arb] | None = None  # the objects at the first crossing, with its t; empty where there is none
    light: arb | None = None  # of a shadow ray: the part of the light that arrives

    def agrees(self, answer, radius: float) -> bool:
        """Whether a method's answer is this one, its t within `radius`."""
        if self.light is not None:
            return bool(abs(self.light - arb(float(answer["light"]))) < arb(2.0**-40))
        index = int(answer["index"])
        if index == NOTHING or not self.hits:
            return index == NOTHING and not self.hits
        return index in self.hits and self.error(answer) <= radius

    def error(self, answer) -> float:
        return float(abs(self.hits[int(answer["index"])] - arb(float(answer["t"]))).upper())


def audit(proofs: World, rows: np.ndarray, blame: Callable[[str, np.void, int, str], None],
          progress: Callable[[float], None] = lambda share: None) -> Audit:
    """Decides `rows` (records.py). `blame(fault, row, object, text)` is called for every contradiction."""
    result = Audit()
    local = local_rays(proofs, rows) if len(rows) else None
    with ctx.workprec(PRECISION):
        for k, row in enumerate(rows):
            verdict = decide(proofs.scene, row, local[:, k])
            _record(result, row, verdict, blame)
            progress((k + 1) / len(rows))
    return result


def decide(scene, row, local) -> Verdict:
    """The exact answer to one ray; `local` (objects, 2, 3) is the ray in every object's own frame."""
    row_alone, lines = row.reshape(1), []
    shadow = row["kind"] == SHADOW
    for index, obj in enumerate(scene.objects):
        o, d = local[index]
        inside = bool(is_inside(row_alone, index)[0])
        line = follow(obj.surface, o, d, inside, row["limit"],
                      only_first=not shadow or obj.material.transparency == 0)
        if line.wrong_start and distance_estimate(obj.surface, o) > ON_SURFACE:
            return Verdict(wrong_side=index)
        lines.append(line)
    verdict = Verdict(next((line.undecided for line in lines if line.undecided), ""),
                      touches=any(line.touches for line in lines))
    if shadow:
        verdict.light = arb(1)
        for obj, line in zip(scene.objects, lines):
            verdict.light *= arb(rational(obj.material.transparency)) ** len(line.crossings)
    else:
        verdict.hits = first_of(lines)
    return verdict


def first_of(lines: list[Line]) -> dict[int, arb]:
    """The objects crossed first: one, or several whose crossings the balls do not tell apart."""
    hits = {index: line.first for index, line in enumerate(lines) if line.first is not None}
    if not hits:
        return {}
    nearest = min(hits.values(), key=lambda t: t.mid().fmpq())
    return {index: t for index, t in hits.items() if not t > nearest}


def _record(result: Audit, row, verdict: Verdict, blame) -> None:
    kind = KINDS[row["kind"]]
    result.rays += 1
    result.by_kind[kind] = result.by_kind.get(kind, 0) + 1
    result.at_edges += bool(row["edge"])
    result.touching += verdict.touches
    if verdict.wrong_side != NOTHING:
        result.wrong += 1
        return blame("wrong side", row, verdict.wrong_side, "f at the origin has the other sign")
    if verdict.undecided:
        result.undecided[verdict.undecided] = result.undecided.get(verdict.undecided, 0) + 1
        return None
    claims = (("proven", "contradictions", "proof contradicted", float(row["radius"])),
              # the audited t may lie on the far side of the enclosure
              ("audited", "wrong", "wrong by exact decision", 2 * float(row["radius"])))
    for name, counter, fault, radius in claims:
        answer = row[name]
        if answer["undecided"] or np.isinf(radius):
            continue
        if not verdict.agrees(answer, radius):
            setattr(result, counter, getattr(result, counter) + 1)
            blame(fault, row, int(answer["index"]), f"exact: {_told(verdict)}")
        elif verdict.hits and answer["index"] != NOTHING:
            error = verdict.error(answer)
            if name == "audited":
                result.largest_error = max(result.largest_error, error)
            else:
                result.largest_share = max(result.largest_share, error / radius)
    return None


def _told(verdict: Verdict) -> str:
    if verdict.light is not None:
        return f"light {float(verdict.light):.9g}"
    if not verdict.hits:
        return "no hit"
    return " and ".join(f"object {k} at t = {float(t):.17g}" for k, t in verdict.hits.items())
