"""Methods that are broken on purpose: the suite has to find each, and to name it."""

from __future__ import annotations

import drjit as dr

from raytruth.comparisons.stability.methods import METHODS, Method
from raytruth.reference_tracer.first_hit.exact import cheapest_exact


class SkipsRoots:
    """An exact method that overlooks about one root in fifty: those of which some low bits say so."""

    name = "skips roots"
    vouches = True

    def __init__(self, setting):
        self.base = cheapest_exact(setting.degree, setting.bounded)

    def first(self, solid, ray, inside, limit):
        crossing = self.base.first(solid, ray, inside, limit)
        scrambled = crossing.t * 2.0**20
        crossing.found &= (scrambled - dr.floor(scrambled)) > 0.02
        return crossing

    def crossings(self, *rays):
        return self.base.crossings(*rays)


class WrongSide:
    """An exact method that takes a ray which starts on a surface for one on the other side of it."""

    name = "wrong side"
    vouches = True

    def __init__(self, setting):
        self.base = cheapest_exact(setting.degree, setting.bounded)

    def first(self, solid, ray, inside, limit):
        return self.base.first(solid, ray, inside ^ self._starts_on(solid, ray), limit)

    def crossings(self, solid, ray, inside, limit, only_first):
        return self.base.crossings(solid, ray, inside ^ self._starts_on(solid, ray), limit, only_first)

    @staticmethod
    def _starts_on(solid, ray):
        return dr.abs(solid.f(*ray.o)) < 1e-9


SKIPS_ROOTS = Method("skips roots", "overlooks one root in fifty", SkipsRoots, claims=True)
WRONG_SIDE = Method("wrong side", "flips the side of secondary rays", WrongSide, claims=True)
# the literal method's root finder, presented as if it could be trusted
FREE_NEWTON = Method("free newton", "leaves its bracket", METHODS[0].build, claims=True)
