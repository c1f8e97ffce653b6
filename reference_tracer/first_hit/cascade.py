"""A fast method first, and a safe one for the rays on which it will not vouch for its answer."""

from __future__ import annotations

import drjit as dr

from .interface import Crossing, FirstHit, LocalRay, Solid


class Cascade:
    """`fast` answers; where it is undecided, `safe` does. No ray is guessed."""

    def __init__(self, fast: FirstHit, safe: FirstHit):
        self.fast, self.safe = fast, safe
        self.name = f"{fast.name}, then {safe.name}"

    def first(self, solid: Solid, ray: LocalRay, inside, limit) -> Crossing:
        a = self.fast.first(solid, ray, inside, limit)
        b = self.safe.first(solid, ray, inside, dr.select(a.undecided, limit, 0))
        pick = lambda of_a, of_b: dr.select(a.undecided, of_b, of_a)
        return Crossing(pick(a.found, b.found), pick(a.t, b.t), pick(a.order, b.order), pick(False, b.undecided),
                        a.evaluations + b.evaluations)

    def crossings(self, solid: Solid, ray: LocalRay, inside, limit, only_first):
        count, unsure = self.fast.crossings(solid, ray, inside, limit, only_first)
        safe_count, still_unsure = self.safe.crossings(solid, ray, inside, dr.select(unsure, limit, 0), only_first)
        return dr.select(unsure, safe_count, count), unsure & still_unsure
