"""Whether rays are on the sides they claim to be on: the bookkeeping of decision M3, checked against f itself."""

from __future__ import annotations

from dataclasses import dataclass

import drjit as dr

from ..numbers import Dual, OutwardInterval
from ..tracer.families import Family
from ..tracer.rays import Ray
from ..tracer.world import World

# Sine of the angle to the surface below which rounding may turn a secondary direction to its other side: directions are
# sums and products of unit vectors, normalised, off by some units in the last place.
TURNED = 2.0**-46


@dataclass
class SideFault:
    """Rays that claim a wrong side, and the last object each claims it of."""

    wrong: object  # Bool
    index: object  # UInt


def side_faults(world: World, ray: Ray, reach) -> SideFault:
    """Where the sides of `ray` contradict f; `reach` (Float) is how far each origin may be off the surface it starts on.

    Away from an object's surface the sign of f at the origin decides, proven by interval arithmetic over the cube of
    `reach`. Within it the sign is noise; there the ray heads to one side of the surface, which the sign of the slope of
    f tells where it is the same in all of the cube. That is asked only where the ray starts on one surface alone: where
    two meet, a ray may have passed one of them and be about to pass the other.
    """
    arrays = world.arrays
    count = arrays.UInt(0)
    far, near = SideFault(arrays.Bool(False), arrays.UInt(0)), SideFault(arrays.Bool(False), arrays.UInt(0))
    for family in world.families:
        far, near, count = _of_family(world, family, ray, reach, far, near, count)
    near.wrong &= count == 1
    return SideFault(far.wrong | near.wrong, dr.select(far.wrong, far.index, near.index))


@dr.syntax
def _of_family(world: World, family: Family, ray: Ray, reach, far: SideFault, near: SideFault, count):
    UInt = world.arrays.UInt
    far_wrong, far_index, near_wrong, near_index = far.wrong, far.index, near.wrong, near.index
    j = UInt(0)
    while j < family.count:
        member = family.member(j)
        local = member.local(ray.o, ray.d)
        cube = tuple(OutwardInterval(local.o[k] - reach, local.o[k] + reach) for k in range(3))
        value, slope, steep = _linear(member.solid.regular(*Dual.axes(cube)), local.d)
        inside = ray.sides.test(member.index)
        contradicted = dr.select(inside, value.low > 0, value.high < 0)
        far_index = dr.select(contradicted, member.index, far_index)
        far_wrong |= contradicted
        on_it = ~(value.low > 0) & ~(value.high < 0)
        leaves = on_it & dr.select(inside, slope.low > steep, slope.high < -steep)
        near_index = dr.select(leaves, member.index, near_index)
        near_wrong |= leaves
        count += dr.select(on_it, UInt(1), 0)
        j += 1
    return SideFault(far_wrong, far_index), SideFault(near_wrong, near_index), count


def _linear(g: Dual, d):
    """f and its slope along d as intervals, and the slope that rounding of d explains."""
    value = OutwardInterval.of(g.value)
    gradient = [OutwardInterval.of(g.derivative(k)) for k in range(3)]
    slope = gradient[0] * d[0] + gradient[1] * d[1] + gradient[2] * d[2]
    size = sum((dr.maximum(dr.abs(c.low), dr.abs(c.high)) for c in gradient[1:]),
               dr.maximum(dr.abs(gradient[0].low), dr.abs(gradient[0].high)))
    return value, slope, TURNED * size
