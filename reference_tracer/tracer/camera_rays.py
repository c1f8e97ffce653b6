"""Section 2 in kernels: the camera's rays through chosen pixels, n x n a pixel (section 5)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import drjit as dr
import numpy as np

from .rays import Sides
from .wavefront import Wave
from .world import World


@dataclass
class CameraRays:
    """The samples of a list of pixels, as a source of waves (wavefront.Source): pixel by pixel, row by row within it.

    The pixels are `first`, first + 1, ..., or those `listed`.
    """

    lane: object  # UInt, 0, 1, 2, ...: one entry a ray
    count: object  # UInt, of pixels
    first: object  # UInt
    listed: object | None  # UInt, one entry a pixel
    samples: int

    def wave(self, world: World, generation: int) -> Wave:
        arrays, per_pixel = world.arrays, self.samples**2
        slot = dr.minimum(self.lane // per_pixel, self.count - 1)
        pixel = slot + self.first if self.listed is None else dr.gather(arrays.UInt, self.listed, slot)
        sample = self.lane % per_pixel
        columns = world.columns
        ray = world.camera_ray(pixel // columns, pixel % columns, sample // self.samples, sample % self.samples,
                               self.samples)
        # a single ray is padded with a second of weight 0, see wavefront
        weight = dr.select(self.lane < self.count * per_pixel, arrays.Float(1), 0)
        return Wave(generation, ray, weight, slot)


def camera_rays(world: World, pixels: range | Sequence[int], samples: int) -> CameraRays:
    """The rays of `pixels`, numbers in row order, with n x n `samples` each (decision C2)."""
    arrays = world.arrays
    lane = dr.arange(arrays.UInt, max(len(pixels) * samples**2, 2))
    dr.make_opaque(lane)
    listed = None if isinstance(pixels, range) else arrays.UInt(np.resize(pixels, max(len(pixels), 2)).astype(np.uint32))
    first = pixels.start if isinstance(pixels, range) else 0
    return CameraRays(lane, arrays.count(len(pixels)), arrays.count(first), listed, samples)


def camera_wave(world: World, sides: Sides, first: int, count: int, samples: int) -> Wave:
    """The camera's rays of pixels [first, first + count) in row order, n x n a pixel, starting on `sides`."""
    wave = camera_rays(world, range(first, first + count), samples).wave(world, 0)
    wave.ray.sides = Sides([word + dr.zeros(world.arrays.Bits, len(wave)) for word in sides.words])
    dr.eval(wave.ray.o, wave.ray.d, wave.ray.sides.words, wave.weight, wave.slot)
    return wave
