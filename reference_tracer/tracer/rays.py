"""Rays, the side of every object each ray is on, and what a ray meets."""

from __future__ import annotations

from dataclasses import dataclass

import drjit as dr

BITS = 63  # objects whose side one word holds


@dataclass
class Sides:
    """For every object of the scene, whether the ray runs inside it: one bit an object (decisions M2, M3).

    A ray inherits its sides from its parent; they are never read off the sign of f at its origin, which lies on a
    surface and is noise. `words` are 64-bit arrays, one for every 63 objects.
    """

    words: list

    @staticmethod
    def from_flags(bits: type, flags: list[bool]) -> Sides:
        words = []
        for start in range(0, len(flags), BITS):
            word = sum(1 << k for k, inside in enumerate(flags[start:start + BITS]) if inside)
            words.append(dr.opaque(bits, word))
        return Sides(words)

    def test(self, index):
        """Whether the ray is inside object `index` (UInt array)."""
        bits = type(self.words[0])
        bit, inside = bits(index), None
        for k, word in enumerate(self.words):
            here = ((word >> (bit - k * BITS)) & 1) != 0
            inside = here if inside is None else dr.select(bit < k * BITS, inside, here)
        return inside

    def flipped(self, index) -> Sides:
        """The sides of a ray that passes through the surface of object `index`."""
        bits = type(self.words[0])
        bit = bits(index)
        if len(self.words) == 1:
            return Sides([self.words[0] ^ (bits(1) << bit)])
        return Sides([word ^ dr.select((bit >= k * BITS) & (bit < (k + 1) * BITS), bits(1) << (bit - k * BITS), bits(0))
                      for k, word in enumerate(self.words)])

    @staticmethod
    def select(condition, if_true: Sides, if_false: Sides) -> Sides:
        return Sides([dr.select(condition, a, b) for a, b in zip(if_true.words, if_false.words)])

    def gather(self, index, active) -> Sides:
        return Sides([dr.gather(type(w), w, index, active) for w in self.words])


@dataclass
class Ray:
    """The half line o + t d, t > 0, with |d| = 1, and the sides it starts on."""

    o: object  # Vector, world space
    d: object  # Vector, unit length
    sides: Sides
    left: object | None = None  # Float, its range, where a path shares one (decision F4)


@dataclass
class Hit:
    """The first crossing of a ray with any object."""

    t: object  # Float, distance along the ray; infinity where nothing was hit
    order: object  # Float, by which crossings are compared first: t itself, or the end of the step that found it
    index: object  # UInt, the object in scene order; the number of objects where nothing was hit
    undecided: object  # Bool, the method cannot vouch for this answer
