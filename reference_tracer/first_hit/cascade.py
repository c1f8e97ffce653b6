"""A fast method first, and a safe one for the rays on which it will not vouch for its answer."""

from __future__ import annotations

import drjit as dr

from .interface import FirstHit, Intersection, LocalRay, Solid


class Cascade:
    """`fast` answers; where it is undecided, `safe` does. No ray is guessed."""

    vouches = True
    closed_form = False
    variables = ()

    def __init__(self, fast: FirstHit, safe: FirstHit):
        self.fast, self.safe = fast, safe
        self.name = f"{fast.name}, then {safe.name}"

    def first(self, solid: Solid, ray: LocalRay, inside, limit) -> Intersection:
        a = self.fast.first(solid, ray, inside, limit)
        return dr.if_stmt((), a.undecided, lambda: self.safe.first(solid, ray, inside, limit), lambda: a)

    def crossings(self, solid: Solid, ray: LocalRay, inside, limit, only_first):
        count, unsure = self.fast.crossings(solid, ray, inside, limit, only_first)
        return dr.if_stmt((), unsure, lambda: self.safe.crossings(solid, ray, inside, limit, only_first),
                          lambda: (count, dr.mask_t(limit)(False)))
