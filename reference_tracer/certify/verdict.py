"""The exact answer to one ray of a scene."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from flint import arb

from ..numbers.exact import rational
from ..scene.model import Scene
from .line import Line, follow
from .origins import starts_on
from .records import NOTHING, SHADOW, is_inside

NO_DIRECTION = "the ray has no direction: the printed sine of refraction exceeds 1 (decision E1)"
AT_ONCE = "two surfaces at one distance"


@dataclass
class Verdict:
    """What a ray does, decided by python-flint."""

    lines: list[Line]  # one an object
    undecided: str = ""  # the reason, empty where everything is decided
    wrong_side: int = NOTHING  # an object whose side the ray claims wrongly
    hits: dict[int, arb] | None = None  # the objects at the first crossing, with its t; empty where there is none
    light: arb | None = None  # of a shadow ray: the part of the light that arrives

    @property
    def tied(self) -> bool:
        """Whether objects are crossed first at one distance: which of them comes first is not to be told (decision M4)."""
        return self.hits is not None and len(self.hits) > 1

    @property
    def touches(self) -> bool:
        return any(line.touches for line in self.lines)

    def agrees(self, answer, radius: float) -> bool:
        """Whether a method's answer (a row of records.ANSWER) is this one, its t within `radius`."""
        if self.light is not None:
            return bool(abs(self.light - arb(float(answer["light"]))) < arb(2.0**-40))
        index = int(answer["index"])
        if index == NOTHING or not self.hits:
            return index == NOTHING and not self.hits
        return index in self.hits and self.error(answer) <= radius

    def error(self, answer) -> float:
        """How far the answer's t is off."""
        return float(abs(self.hits[int(answer["index"])] - arb(float(answer["t"]))).upper())

    def __str__(self):
        if self.light is not None:
            return f"light {float(self.light):.9g}"
        if not self.hits:
            return "no hit"
        return " and ".join(f"object {k} at t = {float(t):.17g}" for k, t in self.hits.items())


def decide(scene: Scene, row: np.void, local: np.ndarray) -> Verdict:
    """The exact answer to the ray of a row (records.py); `local` (objects, 2, 3) is it in every object's own frame.

    Wants flint's precision to be set: it is that of later comparisons.
    """
    if not np.isfinite(row["d"]).all():
        return Verdict([], NO_DIRECTION)
    verdict, shadow = Verdict([]), row["kind"] == SHADOW
    for index, obj in enumerate(scene.objects):
        o, d = local[index]
        inside = bool(is_inside(row.reshape(1), index)[0])
        line = follow(obj.surface, o, d, inside, row["limit"],
                      only_first=not shadow or obj.material.transparency == 0)
        if line.wrong_start and not starts_on(obj.surface, o, float(row["reach"])):
            return Verdict([], wrong_side=index)
        verdict.lines.append(line)
        verdict.undecided = verdict.undecided or line.undecided
    if shadow:
        verdict.light = arb(1)
        for obj, line in zip(scene.objects, verdict.lines):
            if scene.casts_shadow(obj):  # decision F3
                verdict.light *= arb(rational(obj.material.transparency)) ** len(line.crossings)
    else:
        verdict.hits = first_of(verdict.lines)
    return verdict


def first_of(lines: list[Line]) -> dict[int, arb]:
    """The objects crossed first: one, or several whose crossings the balls do not tell apart."""
    hits = {index: line.first for index, line in enumerate(lines) if line.first is not None}
    if not hits:
        return {}
    nearest = min(hits.values(), key=lambda t: t.mid().fmpq())
    return {index: t for index, t in hits.items() if not t > nearest}
