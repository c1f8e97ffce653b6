"""Decision M4 where rounding hides which object a ray meets first: duplicates, coplanar faces, corners of rooms.

The nearest of the computed distances is the first crossing unless another lies so near that rounding may have changed
their order. Only there, and only for methods that vouch for their answers, the signs of all objects just behind the hit
are taken anew, with every rounding counted. Who is certainly still on the ray's side there has not been crossed; who is
not, ties. One object alone is the first, for certain. Of several the first in scene order is taken, and the ray is
undecided.
"""

from __future__ import annotations

import drjit as dr

from .families import Family, Member
from .rays import Hit, Ray

WIDEST = 40  # doublings of a unit in the last place: how far behind a hit signs are looked at


class Margin:
    """Behind a distance, the distances whose order rounding may have changed: far more than it does.

    The crossing of a simple root is computed to rounding, relative to the coordinates' size, divided by the sine of the
    angle between ray and surface; of a root of multiplicity m, to its m-th root. The cube root of rounding covers
    triple roots, and grazing rays whose two crossings are told apart. It costs a question only, never an answer.
    """

    def __init__(self, ray: Ray):
        self.share = dr.epsilon(type(ray.d[0])) ** (1 / 3)
        self.least = self.share * (1 + dr.max(dr.abs(ray.o)))

    def end(self, t):
        """The distance up to which another may tie with t."""
        return dr.fma(t, 1 + self.share, self.least)


def first_of_tied(families: list[Family], ray: Ray, hit: Hit, close):
    """The object met first where `close` (Bool) says that another may tie with the hit, as (UInt index, Bool undecided)."""
    return dr.if_stmt((hit.index, hit.undecided), close,
                      lambda index, undecided: _first_in_scene_order(families, ray, hit.t, index, undecided),
                      lambda *state: state)


@dr.syntax
def _first_in_scene_order(families: list[Family], ray: Ray, t, index, undecided):
    """Steps back from the hit, in doubling distances, until some object is certainly crossed: all others count there."""
    Float, UInt = type(t), type(index)
    r = 2 * dr.epsilon(Float) * dr.maximum(dr.abs(t), 1e-3)
    first, tied, crossed = UInt(index), UInt(0), dr.mask_t(t)(False)
    tries = UInt(0)
    searching = dr.mask_t(t)(True)
    while searching:
        first, tied, crossed = _behind(families, ray, t + r, UInt(0xffffffff), UInt(0), dr.mask_t(t)(False))
        r *= 2
        tries += 1
        searching = ~crossed & (tries < WIDEST)
    return dr.select(crossed, first, index), undecided | ~crossed | (tied > 1)


def _behind(families: list[Family], ray: Ray, t, first, tied, crossed):
    """Which objects are not certainly on the ray's own side at t: the lowest index, how many, and whether one of them is
    certainly on the other."""
    def step(member: Member, first, tied, crossed):
        negative, positive = member.signs_at(ray.o, ray.d, t)
        inside = ray.sides.test(member.index)
        stays, crosses = dr.select(inside, negative, positive), dr.select(inside, positive, negative)
        return (dr.select(stays, first, dr.minimum(first, member.index)), tied + dr.select(stays, type(tied)(0), 1),
                crossed | crosses)

    state = first, tied, crossed
    for family in families:
        state = family.fold(step, state, lambda ball, *_: ball.may_meet(ray.o, ray.d, t), unrolled=False)
    return state
