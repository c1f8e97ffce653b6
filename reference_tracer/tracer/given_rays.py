"""Rays that are given one by one in place of a camera's, so that single rays are traced as pictures are."""

from __future__ import annotations

from dataclasses import dataclass

import drjit as dr
import numpy as np

from ..scene.model import LONGEST_SIDE, Scene
from ..scene.placement import is_inside
from .rays import BITS, Ray, Sides
from .world import World


@dataclass(frozen=True)
class GivenRays:
    """Rays `o` + t `d`, both (n, 3) fp64, n >= 2, |d| = 1. Each starts on the sides that f has at its origin, as a camera's
    ray does (decision M3), and is a pixel of a picture of n x 1."""

    o: np.ndarray
    d: np.ndarray

    def __post_init__(self):
        if not 2 <= len(self.o) <= LONGEST_SIDE:
            raise ValueError(f"from 2 to {LONGEST_SIDE} rays can be given at once")

    def scene(self, scene: Scene) -> Scene:
        """`scene` with a pixel for every ray."""
        return scene.resized(len(self.o), 1, samples=1)

    def rays(self, world: World) -> Ray:
        """All of them, in the order of the pixels."""
        arrays, literal = world.arrays, world.literal
        inside = np.array([[is_inside(obj, o, literal(obj)) for obj in world.scene.objects] for o in self.o], np.uint64)
        words = [arrays.Bits((inside[:, k:k + BITS] << np.arange(inside[:, k:k + BITS].shape[1], dtype=np.uint64)).sum(1))
                 for k in range(0, inside.shape[1], BITS)]
        number = lambda column: arrays.Float(np.ascontiguousarray(column))
        left = number(np.full(len(self.o), world.scene.tracing.max_distance)) if world.scene.tracing.range == "path" else None
        return Ray(arrays.Vector(*map(number, self.o.T)), arrays.Vector(*map(number, self.d.T)), Sides(words), left)


class GivenWorld(World):
    """A world whose camera's rays are `given`, one a pixel of `GivenRays.scene`; without any, the camera's own."""

    def __init__(self, *of_world, given: GivenRays | None):
        super().__init__(*of_world)
        self.given = given and given.rays(self)
        dr.make_opaque(self.given)

    @property
    def variables(self) -> list:
        return [*super().variables, self.given]

    def camera_ray(self, row, column, sample_row, sample_column, samples: int) -> Ray:
        if self.given is None:
            return super().camera_ray(row, column, sample_row, sample_column, samples)
        pick = lambda values: dr.gather(type(values), values, column)
        left = None if self.given.left is None else pick(self.given.left)
        return Ray(pick(self.given.o), pick(self.given.d), self.given.sides.gather(column, True), left)
