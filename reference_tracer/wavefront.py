"""The fast tracer: all rays of one generation at a time, in queues of bounded length.

The recursion of section 4.3 becomes a work list. A wave of rays is traced by one kernel; its secondary rays, with the
weight each has in its pixel, make up to two new waves. A wave longer than `MOST_RAYS` is split before it is traced,
and the newest wave is traced first, so that memory stays bounded at any picture size and any depth.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import drjit as dr

from .rays import Ray, Sides
from .shading import Collision, collide
from .world import World

MOST_RAYS = 1 << 19  # about 130 MB of queues and intermediate results
REFRACTED = 1 << 31  # marks a refraction ray in a queue
NO_RAY = (1 << 32) - 1  # pads a queue


@dataclass
class Wave:
    """Rays of one generation; `weight` is each one's share in the colour of `slot`."""

    generation: int
    ray: Ray
    weight: object  # Float
    slot: object  # UInt
    refracted: object = None  # Bool, which rays came through a surface; None for camera rays

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

    # Direct: the default mode depends on the film's size, and kernels with it
    def add(self, wave: Wave, color) -> None:
        dr.scatter_add(self.color, color * wave.weight, wave.slot, mode=dr.ReduceMode.Direct)

    def note(self, wave: Wave, undecided, generation) -> None:
        UInt = type(self.undecided)
        for plane, value in ((self.undecided, dr.select(undecided, UInt(1), 0)), (self.generation, generation)):
            # rays of weight 0 pad the queue and belong to no pixel
            dr.scatter_reduce(dr.ReduceOp.Max, plane, value, wave.slot, wave.weight > 0, mode=dr.ReduceMode.Direct)


def trace(world: World, wave: Wave, slots: int,
          observe: Callable[[Wave, Collision], None] | None = None,
          disturb: Callable[[Wave], Ray] | None = None) -> tuple[Film, Primary]:
    """Traces `wave` and all its descendants. The first wave must not exceed MOST_RAYS and yields the primary hits.

    `observe` is called with every wave and what became of it, before its secondary rays are traced; `disturb` may
    replace the rays of every wave before they are traced.
    """
    arrays = world.arrays
    film = Film(dr.zeros(arrays.Vector, slots), dr.zeros(arrays.UInt, slots), dr.zeros(arrays.UInt, slots))
    dr.make_opaque(film.color, film.generation, film.undecided)
    primary, waves = None, [wave]
    while waves:
        wave = waves.pop()
        film.rays += len(wave)
        if disturb:
            wave.ray = disturb(wave)
        collision = collide(world, wave.ray, active=wave.weight > 0)
        film.add(wave, collision.color)
        film.note(wave, collision.undecided, world.generation(wave.generation))
        if primary is None:
            primary = Primary(dr.select(collision.hit.index < world.object_count, collision.hit.t, dr.inf),
                              collision.point, collision.normal, collision.hit.index)
        dr.eval(film.color, film.generation, film.undecided, collision)
        if observe:
            observe(wave, collision)
        waves += _secondary_waves(world, wave, collision, film)
    return film, primary


def _secondary_waves(world: World, wave: Wave, collision: Collision, film: Film) -> list[Wave]:
    """The reflection and refraction rays of `wave`; beyond max_depth they see the background (decision D1)."""
    kinds = [(weight, refracts) for weight, refracts in
             ((collision.reflected_weight, False), (collision.refracted_weight, True)) if weight is not None]
    if wave.generation == world.scene.tracing.max_depth:
        if any(world.scene.background):
            for weight, _ in kinds:
                film.add(wave, world.arrays.Vector(*world.background) * weight)
        return []
    chosen = [(dr.compress(weight > 0), refracts) for weight, refracts in kinds]
    queue = _queue(world, chosen)
    return [_gathered(world, wave, collision, queue, start) for start in range(0, dr.width(queue), MOST_RAYS)]


def _queue(world: World, chosen):
    """The rows of reflection rays, then those of refraction rays with REFRACTED added, in one array."""
    UInt = world.arrays.UInt
    lengths = [dr.width(rows) for rows, _ in chosen]
    if not sum(lengths):
        return UInt()
    # a queue of one ray would be taken for a constant and compile kernels of its own: pad it with one that is NO_RAY
    queue = dr.full(UInt, NO_RAY, max(sum(lengths), 2))
    start = 0
    for (rows, refracts), length in zip(chosen, lengths):
        if length:
            dr.scatter(queue, rows | (REFRACTED if refracts else 0),
                       dr.arange(UInt, length) + world.arrays.count(start))
        start += length
    dr.eval(queue)
    return queue


def _gathered(world: World, wave: Wave, collision: Collision, queue, start: int) -> Wave:
    """The rays that `queue` lists from `start` on, at most MOST_RAYS of them."""
    arrays = world.arrays
    lane = dr.arange(arrays.UInt, max(min(MOST_RAYS, dr.width(queue) - start), 2)) + arrays.count(start)
    entry = dr.select(lane < arrays.count(dr.width(queue)), dr.gather(arrays.UInt, queue, lane), NO_RAY)
    active = entry != NO_RAY
    row = entry & (REFRACTED - 1)
    pick = lambda kind, value: dr.gather(kind, value, row, active)
    d, weight = pick(arrays.Vector, collision.reflected), pick(arrays.Float, collision.reflected_weight)
    sides = wave.ray.sides.gather(row, active)
    if collision.refracted is not None:
        through = (entry & REFRACTED) != 0
        d = dr.select(through, pick(arrays.Vector, collision.refracted), d)
        weight = dr.select(through, pick(arrays.Float, collision.refracted_weight), weight)
        sides = Sides.select(through, collision.refracted_sides.gather(row, active), sides)
    child = Wave(wave.generation + 1, Ray(pick(arrays.Vector, collision.point), d, sides),
                 dr.select(active, pick(arrays.Float, wave.weight) * weight, 0), pick(arrays.UInt, wave.slot),
                 refracted=active & ((entry & REFRACTED) != 0))
    dr.eval(child.ray.o, child.ray.d, child.ray.sides.words, child.weight, child.slot)
    return child
