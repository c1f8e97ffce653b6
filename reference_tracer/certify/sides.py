"""Whether rays are on the sides they claim to be on: the bookkeeping of decision M3, checked against f itself."""

from __future__ import annotations

from dataclasses import dataclass

import drjit as dr

from ..numbers import Dual, OutwardInterval
from ..rays import Ray
from ..world import Family, World

NEARNESS = 2.0**-40  # of the coordinates' size: a ray that starts so close to a surface may have started on it


@dataclass
class SideFault:
    """Rays that claim a wrong side, and the last object each claims it of."""

    wrong: object  # Bool
    index: object  # UInt


def side_faults(world: World, ray: Ray) -> SideFault:
    """Where the sides of `ray` contradict f.

    Away from an object's surface the sign of f at the origin decides, proven by interval arithmetic over a small cube.
    On a surface it is noise; there the ray heads to one side of it, which the sign of the slope of f tells. That is
    asked only where the ray starts on one surface alone: of two that coincide, a ray may be about to enter the second.
    """
    arrays = world.arrays
    count = arrays.UInt(0)
    far, near = SideFault(arrays.Bool(False), arrays.UInt(0)), SideFault(arrays.Bool(False), arrays.UInt(0))
    for family in world.families:
        far, near, count = _of_family(world, family, ray, far, near, count)
    near.wrong &= count == 1
    return SideFault(far.wrong | near.wrong, dr.select(far.wrong, far.index, near.index))


@dr.syntax
def _of_family(world: World, family: Family, ray: Ray, far: SideFault, near: SideFault, count):
    UInt = world.arrays.UInt
    far_wrong, far_index, near_wrong, near_index = far.wrong, far.index, near.wrong, near.index
    size = dr.max(dr.abs(ray.o))
    j = UInt(0)
    while j < family.count:
        member = family.member(j)
        local = member.local(ray.o, ray.d)
        reach = NEARNESS * (1 + size + dr.max(dr.abs(local.o)))
        cube = tuple(OutwardInterval(local.o[k] - reach, local.o[k] + reach) for k in range(3))
        g = member.solid.regular(*Dual.along(cube, tuple(OutwardInterval(local.d[k]) for k in range(3))))
        value, slope = OutwardInterval.of(g.value), OutwardInterval.of(g.derivative())
        inside = ray.sides.test(member.index)
        contradicted = dr.select(inside, value.low > 0, value.high < 0)
        far_index = dr.select(contradicted, member.index, far_index)
        far_wrong |= contradicted
        on_it = ~(value.low > 0) & ~(value.high < 0)
        leaves = on_it & dr.select(inside, slope.low > 0, slope.high < 0)
        near_index = dr.select(leaves, member.index, near_index)
        near_wrong |= leaves
        count += dr.select(on_it, UInt(1), 0)
        j += 1
    return SideFault(far_wrong, far_index), SideFault(near_wrong, near_index), count
