"""Whether rays are on the sides they claim to be on: the bookkeeping of decision M3, checked against f itself."""

from __future__ import annotations

from dataclasses import dataclass

import drjit as dr

from ..families import Family
from ..numbers import Dual, OutwardInterval
from ..rays import Ray
from ..world import World

NEARNESS = 2.0**-40  # of the coordinates' size: a ray that starts so close to a surface may have started on it
SMOOTHNESS = 2.0**-20  # change of grad f within that distance, relative, above which it is a kink


@dataclass
class SideFault:
    """Rays that claim a wrong side, and the last object each claims it of."""

    wrong: object  # Bool
    index: object  # UInt


def side_faults(world: World, ray: Ray) -> SideFault:
    """Where the sides of `ray` contradict f.

    Away from an object's surface the sign of f at the origin decides, proven by interval arithmetic over a small cube.
    On a surface it is noise; there the ray heads to one side of it, which the sign of the slope of f tells. That is
    asked only where the ray starts on one smooth surface alone: where two meet, or at a kink, a ray may have passed one
    of them and be about to pass the other.
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
        value, slope, smooth = _linear(member.solid.regular(*Dual.axes(cube)), local.d)
        inside = ray.sides.test(member.index)
        contradicted = dr.select(inside, value.low > 0, value.high < 0)
        far_index = dr.select(contradicted, member.index, far_index)
        far_wrong |= contradicted
        on_it = ~(value.low > 0) & ~(value.high < 0)
        leaves = on_it & smooth & dr.select(inside, slope.low > 0, slope.high < 0)
        near_index = dr.select(leaves, member.index, near_index)
        near_wrong |= leaves
        count += dr.select(on_it, UInt(1), 0)
        j += 1
    return SideFault(far_wrong, far_index), SideFault(near_wrong, near_index), count


def _linear(g: Dual, d):
    """f and its slope along d as intervals, and whether grad f is nearly constant (Bool)."""
    value = OutwardInterval.of(g.value)
    gradient = [OutwardInterval.of(g.derivative(k)) for k in range(3)]
    slope = gradient[0] * d[0] + gradient[1] * d[1] + gradient[2] * d[2]
    spread = sum((c.high - c.low for c in gradient[1:]), gradient[0].high - gradient[0].low)
    size = sum((dr.abs(c.high) for c in gradient[1:]), dr.abs(gradient[0].high))
    return value, slope, spread < SMOOTHNESS * size
