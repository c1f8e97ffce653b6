"""The fast tracer: all rays of one generation at a time, in queues of bounded length.

The recursion of section 4.3 becomes a work list. A wave of rays is traced by one kernel; its secondary rays, with the
weight each has in its pixel, make up to two new waves. A wave longer than `MOST_RAYS` is split before it is traced,
and the newest wave is traced first, so that memory stays bounded at any picture size and any depth.

What a kernel needs of a wave's parents it reads itself, and it is recorded once and replayed for later waves: between
two generations only the rays that go on are listed.

At most one wave of each generation waits with its interactions for its secondary rays: those of all generations together
take no more than `MOST_HELD`, since deep waves are split into shorter ones, but for `LEAST_PART` rows a generation.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import drjit as dr

from ..backend import recorded
from ..scene.model import Scene
from .compilation import announce
from .rays import BITS, Hit, Ray, Sides
from .shading import Interaction, interact
from .world import World

MOST_RAYS = 1 << 20  # about 200 MB of intermediate results
MOST_HELD = 1 << 29  # bytes of interactions that wait for their secondary rays
LEAST_PART = 1 << 13  # rays of a wave, below which a kernel's launch costs more than its work
REFRACTED = 1 << 31  # marks a refraction ray in a queue
NO_RAY = (1 << 32) - 1  # pads a queue
DECIDED, IN_DOUBT, NO_COLOR = 0, 1, 2  # of a pixel: the worst of its rays counts


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
    point: object  # Vector, NaN where nothing was hit
    normal: object  # Vector, NaN where nothing was hit
    index: object  # UInt, the object in scene order; the number of objects where nothing was hit

    @staticmethod
    def of(world: World, hit: Hit, point, normal) -> Primary:
        met = hit.index < world.object_count
        return Primary(dr.select(met, hit.t, dr.inf), dr.select(met, point, dr.nan), dr.select(met, normal, dr.nan),
                       hit.index)


@dataclass
class Film:
    """What the rays of a band add up to, one entry a slot (a pixel).

    Rays of one pixel are added by several threads in any order. Sums of whole numbers do not depend on it, those of
    floats do: colours are added up as multiples of `World.color_unit`, so that a picture repeats to the last bit.
    """

    color: object  # vector of Int64, in units of `World.color_unit`
    generation: object  # UInt, the highest generation of rays that was traced
    doubt: object  # UInt, DECIDED, IN_DOUBT where any ray was undecided, NO_COLOR where any colour is not finite

    @staticmethod
    def blank(arrays, slots: int) -> Film:
        film = Film(dr.zeros(dr.int64_array_t(arrays.Vector), slots), dr.zeros(arrays.UInt, slots),
                    dr.zeros(arrays.UInt, slots))
        dr.make_opaque(film.color, film.generation, film.doubt)
        return film

    # Direct: the default mode depends on the film's size, and kernels with it
    def add(self, world: World, color, weight, slot):
        """Adds `color` times `weight`; returns where that is finite (Bool). What is not finite is not added."""
        share = color * weight
        finite = dr.isfinite(dr.sum(share))
        units = dr.round(dr.float64_array_t(share)(share) * world.units_of_color)
        dr.scatter_add(self.color, type(self.color)(dr.select(finite, units, 0)), slot, mode=dr.ReduceMode.Direct)
        return finite

    def note(self, wave: Wave, undecided, finite, generation) -> None:
        # rays of weight 0 pad the queue and belong to no pixel; those of one pixel write the same generation
        traced = wave.weight > 0
        doubt = dr.select(finite, type(self.doubt)(IN_DOUBT), NO_COLOR)
        dr.scatter_reduce(dr.ReduceOp.Max, self.doubt, doubt, wave.slot, traced & (undecided | ~finite),
                          mode=dr.ReduceMode.Direct)
        highest = dr.maximum(dr.gather(type(generation), self.generation, wave.slot, traced), generation)
        dr.scatter(self.generation, highest, wave.slot, traced)


class Source(Protocol):
    """Where the rays of a wave come from: a PyTree of arrays, from which a kernel makes them."""

    def wave(self, world: World, generation: int) -> Wave:
        """The rays."""


@dataclass
class Traced:
    """A wave that is at hand."""

    ray: Ray
    weight: object
    slot: object

    def wave(self, world: World, generation: int) -> Wave:
        return Wave(generation, self.ray, self.weight, self.slot)


@dataclass
class Parents:
    """What secondary rays need of the interactions that they leave from, one entry a interaction."""

    point: object  # Vector
    slot: object  # UInt
    sides: Sides
    reflected: object | None  # Vector, direction
    reflected_weight: object | None  # Float, share in the pixel
    refracted: object | None  # Vector, direction
    refracted_weight: object | None  # Float, share in the pixel
    refracted_sides: Sides | None
    left: object | None  # Float, the range that is left to secondary rays (decision F4)

    @staticmethod
    def of(world: World, wave: Wave, interaction: Interaction) -> Parents:
        weighted = lambda weight: None if weight is None else weight * wave.weight
        return Parents(interaction.point, wave.slot, wave.ray.sides, interaction.reflected,
                       weighted(interaction.reflected_weight), interaction.refracted, weighted(interaction.refracted_weight),
                       interaction.refracted_sides,
                       world.range_after(wave.ray, interaction.hit))

    @property
    def weights(self) -> list:
        """The weights of the reflection and of the refraction rays, with whether they refract; those there are."""
        kinds = ((self.reflected_weight, False), (self.refracted_weight, True))
        return [(weight, refracts) for weight, refracts in kinds if weight is not None]


def row_bytes(scene: Scene) -> int:
    """The bytes that an interaction takes in `Parents`, in double precision."""
    sides = 8 * -(-len(scene.objects) // BITS)
    refracts = any(obj.material.transparency > 0 for obj in scene.objects)
    kept = 24 + 4 + sides + (8 if scene.tracing.range == "path" else 0)  # point, slot, sides and what is left of the range
    return kept + 32 + refracts * (32 + sides)  # direction and weight of each kind of ray


@dataclass
class Secondary:
    """The secondary rays that `queue` lists: rows of `parents`, REFRACTED added to those of refraction rays."""

    parents: Parents
    queue: object  # UInt

    def wave(self, world: World, generation: int) -> Wave:
        arrays, parents, entry = world.arrays, self.parents, self.queue
        active = entry != NO_RAY
        row = entry & (REFRACTED - 1)
        through = active & ((entry & REFRACTED) != 0)
        pick = lambda kind, value, mask: dr.gather(kind, value, row, mask)
        sides = parents.sides.gather(row, active)
        d, weight = dr.zeros(arrays.Vector), arrays.Float(0)
        if parents.reflected_weight is not None:
            d = pick(arrays.Vector, parents.reflected, active & ~through)
            weight = pick(arrays.Float, parents.reflected_weight, active & ~through)
        if parents.refracted_weight is not None:
            d = dr.select(through, pick(arrays.Vector, parents.refracted, through), d)
            weight = dr.select(through, pick(arrays.Float, parents.refracted_weight, through), weight)
            sides = Sides.select(through, parents.refracted_sides.gather(row, through), sides)
        left = None if parents.left is None else pick(arrays.Float, parents.left, active)
        return Wave(generation, Ray(pick(arrays.Vector, parents.point, active), d, sides, left), weight,
                    pick(arrays.UInt, parents.slot, active), refracted=through)


@dataclass(frozen=True)
class Advance:
    """A wave has been traced."""

    generation: int
    rays: int
    secondary: int  # rays that go on from it
    share: float  # of the whole tree of waves, as far as it can be told; rises to 1


class Recorder(Protocol):
    """Disturbs and observes within the recording. It reads nothing but the world, whose `variables` hold all that it needs,
    and writes nothing but `marks`, a PyTree of arrays."""

    marks: object

    def begin_wave(self, world: World) -> None:
        """Outside of the recording: a wave is about to be traced in `world`."""

    def disturb(self, world: World, wave: Wave) -> Ray:
        """The rays to trace in place of the wave's."""

    def observe(self, world: World, wave: Wave, generation, interaction: Interaction) -> None:
        """What became of a wave of `generation` (UInt)."""


class Wavefront:
    """Traces waves and all their descendants in one world; another of the same kind may take its place between two calls.

    `observe` is called with every wave and what became of it, before its secondary rays are traced; `disturb` may
    replace the rays of every wave before they are traced. A `recorder` does both without leaving the kernels.
    """

    def __init__(self, world: World, observe: Callable[[Wave, Interaction], None] | None = None,
                 disturb: Callable[[Wave], Ray] | None = None, recorder: Recorder | None = None):
        self.world, self.observe, self.disturb, self.recorder = world, observe, disturb, recorder
        self.rays, self._announced, self._row = 0, False, row_bytes(world.scene)
        self._recorded = recorded(self._step)

    def trace(self, source: Source, count: int, slots: int, primary: bool = True,
              progress: Callable[[Advance], None] | None = None) -> tuple[Film, Primary | None]:
        """Traces the `count` rays of `source`, at most MOST_RAYS, and all their descendants.

        Returns the film and, if `primary`, what the first rays met. `progress` is called after every wave.
        """
        film = Film.blank(self.world.arrays, slots)
        met, waves, done = None, [(0, source, count, 1.0)], 0.0
        held = [0] * (self.world.scene.tracing.max_depth + 1)  # interactions of each generation that are waited for
        while waves:
            generation, source, count, share = waves.pop()
            self.rays += count
            parents, film, found = self._traced(source, film, generation, primary and met is None)
            met = met or found
            queues = []
            if parents is not None:
                held[generation] = count
                queues = self._queues(parents, generation + 1, self._longest(sum(held[:generation + 1])))
            lengths = [dr.width(queue) for queue in queues]
            secondary = sum(lengths)
            # as if in the generations to come as many rays went on: of each ray that many, of each of those again, ...
            own = share / sum((secondary / count)**k for k in range(len(held) - generation))
            waves += [(generation + 1, Secondary(parents, queue), length, (share - own) * length / secondary)
                      for queue, length in zip(queues, lengths)]
            done += own
            if progress:
                progress(Advance(generation, count, secondary, min(done, 1.0)))
        return film, met

    def _longest(self, held: int) -> int:
        """How many rays the next wave may have: half of the room that is left, so that any depth fits."""
        return min(MOST_RAYS, max(LEAST_PART, (MOST_HELD // self._row - held) // 2))

    def _traced(self, source: Source, film: Film, generation: int, primary: bool):
        last = generation == self.world.scene.tracing.max_depth
        inputs = source, film, self.world.generation(generation), last, primary
        if self.observe or self.disturb:
            return self._step(*inputs, wave=self._watched(source, generation))[:3]
        if self.recorder is None:
            return self._recorded(*inputs, self.world.variables)[:3]
        self.recorder.begin_wave(self.world)
        *found, self.recorder.marks = self._recorded(*inputs, self.world.variables, self.recorder.marks)
        return found

    def _watched(self, source: Source, generation: int) -> Wave:
        wave = source.wave(self.world, generation)
        dr.eval(wave.ray.o, wave.ray.d, wave.ray.sides.words, wave.ray.left, wave.weight, wave.slot)
        if self.disturb:
            wave.ray = self.disturb(wave)
        return wave

    def _step(self, source: Source, film: Film, generation, last: bool, primary: bool, variables=None, marks=None,
              wave: Wave | None = None):
        """One wave: its kernel. `variables` are all arrays that a recording reads besides its other inputs, `marks` those that
        its recorder writes."""
        world, watched = self.world, wave is not None
        wave = wave or source.wave(world, -1)
        if marks is not None:
            wave.ray = self.recorder.disturb(world, wave)
        interaction = interact(world, wave.ray, active=wave.weight > 0)
        finite = film.add(world, interaction.color, wave.weight, wave.slot)
        film.note(wave, interaction.undecided, finite, generation)
        parents = Parents.of(world, wave, interaction)
        if last:  # beyond the last generation lies the background (decision D1)
            if any(world.scene.background):
                for weight, _ in parents.weights:
                    film.add(world, world.arrays.Vector(*world.background), weight, wave.slot)
            parents = None
        met = Primary.of(world, interaction.hit, interaction.point, interaction.normal) if primary else None
        if not self._announced:
            self._announced = True
            announce(1 + min(world.scene.tracing.max_depth, 2) * bool(parents and parents.weights), world.arrays)
        if watched:
            dr.eval(film, interaction)
            if self.observe:
                self.observe(wave, interaction)
        if marks is not None:
            self.recorder.observe(world, wave, generation, interaction)
        dr.eval(film, parents if parents and parents.weights else None, met, marks)
        return (parents if parents and parents.weights else None), film, met, marks

    # --- queues ----------------------------------------------------------------------------------------------------
    def _queues(self, parents: Parents, generation: int, most: int) -> list:
        """The secondary rays that go on, in arrays of at most `most` rows; see `Secondary`."""
        least = self.world.least_weight(generation)
        queue = self._queue([(dr.compress(weight > least), refracts) for weight, refracts in parents.weights])
        length = dr.width(queue)
        if length <= most:
            return [queue] if length else []
        return [self._part(queue, start, most) for start in range(0, length, most)]

    def _queue(self, chosen):
        """The rows of reflection rays, then those of refraction rays with REFRACTED added, in one array."""
        UInt = self.world.arrays.UInt
        lengths = [dr.width(rows) for rows, _ in chosen]
        if not sum(lengths):
            return UInt()
        # a queue of one ray would be taken for a constant and compile kernels of its own: pad it with one that is NO_RAY
        queue = dr.full(UInt, NO_RAY, max(sum(lengths), 2))
        start = 0
        for (rows, refracts), length in zip(chosen, lengths):
            if length:
                dr.scatter(queue, rows | (REFRACTED if refracts else 0),
                           dr.arange(UInt, length) + self.world.arrays.count(start))
            start += length
        dr.eval(queue)
        return queue

    def _part(self, queue, start: int, most: int):
        """`most` rows of `queue` from `start` on, or as many as there are, padded to two."""
        arrays = self.world.arrays
        lane = dr.arange(arrays.UInt, max(min(most, dr.width(queue) - start), 2)) + arrays.count(start)
        there = lane < arrays.count(dr.width(queue))
        part = dr.select(there, dr.gather(arrays.UInt, queue, lane, there), NO_RAY)
        dr.eval(part)
        return part


def trace(world: World, wave: Wave, slots: int,
          observe: Callable[[Wave, Interaction], None] | None = None,
          disturb: Callable[[Wave], Ray] | None = None) -> tuple[Film, Primary]:
    """Traces `wave`, of at most MOST_RAYS rays, and all its descendants; see `Wavefront`."""
    return Wavefront(world, observe, disturb).trace(Traced(wave.ray, wave.weight, wave.slot), len(wave), slots)
