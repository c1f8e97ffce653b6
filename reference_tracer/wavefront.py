"""The fast tracer: all rays of one generation at a time, in queues of bounded length.

The recursion of section 4.3 becomes a work list. A wave of rays is traced by one kernel; its secondary rays, with the
weight each has in its pixel, make up to two new waves. A wave longer than `MOST_RAYS` is split before it is traced,
and the newest wave is traced first, so that memory stays bounded at any picture size and any depth.
"""

from __future__ import annotations

from dataclasses import dataclass

import drjit as dr

from .rays import Ray, Sides
from .shading import Collision, collide
from .world import World

MOST_RAYS = 1 << 19  # about 130 MB of queues and intermediate results


@dataclass
class Wave:
    """Rays of one generation; `weight` is each one's share in the colour of `slot`."""

    generation: int
    ray: Ray
    weight: object  # Float
    slot: object  # UInt

    def __len__(self):
        return dr.width(self.slot)


@dataclass
class Primary:
    """What the first wave met, one entry a ray."""

    t: object  # Float, infinity where nothing was hit
    point: object  # Vector
    normal: object  # Vector
    index: object  # UInt


@dataclass
class Film:
    """What the rays of a band add up to, one entry a slot (a pixel)."""

    color: object  # Vector
    generation: object  # UInt, the highest generation of rays that was traced
    undecided: object  # UInt, 1 where any ray was undecided
    rays: int = 0


def trace(world: World, wave: Wave, slots: int) -> tuple[Film, Primary]:
    """Traces `wave` and all its descendants. The first wave must not exceed MOST_RAYS and yields the primary hits."""
    arrays = world.arrays
    film = Film(dr.zeros(arrays.Vector, slots), dr.zeros(arrays.UInt, slots), dr.zeros(arrays.UInt, slots))
    primary, waves = None, [wave]
    while waves:
        wave = waves.pop()
        film.rays += len(wave)
        collision = collide(world, wave.ray, active=wave.weight > 0)
        dr.scatter_add(film.color, collision.color * wave.weight, wave.slot)
        dr.scatter_reduce(dr.ReduceOp.Max, film.undecided, dr.select(collision.undecided, arrays.UInt(1), 0), wave.slot)
        dr.scatter_reduce(dr.ReduceOp.Max, film.generation, world.generation(wave.generation), wave.slot)
        if primary is None:
            primary = Primary(dr.select(collision.hit.index < world.object_count, collision.hit.t, dr.inf),
                              collision.point, collision.normal, collision.hit.index)
        dr.eval(film.color, film.generation, film.undecided, collision, collision.hit.t, collision.hit.index)
        waves += _secondary_waves(world, wave, collision, film)
    return film, primary


def _secondary_waves(world: World, wave: Wave, collision: Collision, film: Film) -> list[Wave]:
    """The reflection and refraction rays of `wave`; beyond max_depth they see the background (decision D1)."""
    last = wave.generation == world.scene.tracing.max_depth
    children = []
    for direction, weight, sides in (
            (collision.reflected, collision.reflected_weight, wave.ray.sides),
            (collision.refracted, collision.refracted_weight, collision.refracted_sides)):
        if weight is None:
            continue
        if last:
            if any(world.scene.background):
                dr.scatter_add(film.color, world.arrays.Vector(*world.background) * (wave.weight * weight), wave.slot)
            continue
        chosen = dr.compress(weight > 0)
        for start in range(0, dr.width(chosen), MOST_RAYS):
            children.append(_gathered(world, wave, collision, direction, weight, sides, chosen, start))
    return children


def _gathered(world, wave, collision, direction, weight, sides, chosen, start) -> Wave:
    arrays = world.arrays
    count = min(MOST_RAYS, dr.width(chosen) - start)
    # a queue of one ray would be taken for a constant and compile kernels of its own: pad it with a ray of weight 0
    lane = dr.arange(arrays.UInt, max(count, 2))
    active = lane < arrays.count(count)
    index = dr.gather(arrays.UInt, chosen, lane + arrays.count(start), active)
    pick = lambda kind, value: dr.gather(kind, value, index, active)
    child = Wave(wave.generation + 1,
                 Ray(pick(arrays.Vector, collision.point), pick(arrays.Vector, direction), sides.gather(index, active)),
                 pick(arrays.Float, wave.weight) * pick(arrays.Float, weight), pick(arrays.UInt, wave.slot))
    dr.eval(child.ray.o, child.ray.d, child.ray.sides.words, child.weight, child.slot)
    return child
