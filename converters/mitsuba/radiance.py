"""What one of Mitsuba's own integrators sees along the document's camera rays."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from raytruth.reference_tracer.scene.model import Camera

from .sensor import document_directions
from .variant import dr, mi

MOST_RAYS = 1 << 20  # at a time


@dataclass(frozen=True)
class Radiance:
    """The mean of `samples` samples a pixel and its variance, (h, w, 3) fp64."""

    mean: np.ndarray
    variance: np.ndarray  # of the mean
    samples: int


def radiance(scene: mi.Scene, integrator: dict, camera: Camera, samples: int = 1, seed: int = 0) -> Radiance:
    """Follows `samples` paths from every pixel's centre.

    The sum over samples is taken in fp64 about the first block's mean, so that what does not vary has no variance.
    """
    traced = mi.load_dict(integrator)
    directions = document_directions(camera).astype(np.float32)
    pixels = len(directions)
    block = max(1, min(samples, MOST_RAYS // pixels))
    total = squares = shift = None
    for first in range(0, samples, block):
        count = min(block, samples - first)
        seen = _block(scene, traced, camera, directions, count, seed + 7919 * first)
        shift = seen.mean(axis=1, keepdims=True) if shift is None else shift
        seen -= shift
        total = seen.sum(axis=1) + (0 if total is None else total)
        squares = (seen**2).sum(axis=1) + (0 if squares is None else squares)
    shape = camera.height, camera.width, 3
    mean = total / samples
    variance = np.maximum(squares / samples - mean**2, 0) / max(samples - 1, 1)
    return Radiance((shift[:, 0] + mean).reshape(shape), variance.reshape(shape), samples)


def _block(scene, integrator, camera: Camera, directions: np.ndarray, count: int, seed: int) -> np.ndarray:
    """(pixels, count, 3) fp64: one block of samples."""
    lanes = len(directions) * count
    pixel = dr.arange(mi.UInt32, lanes) // dr.opaque(mi.UInt32, count)
    d = mi.Vector3f(*(dr.gather(mi.Float, mi.Float(np.ascontiguousarray(c)), pixel) for c in directions.T))
    origin = mi.Point3f(*(dr.opaque(mi.Float, c) for c in camera.position))
    sampler = mi.load_dict({"type": "independent"})
    sampler.seed(seed, lanes)
    color, _, _ = integrator.sample(scene, sampler, mi.RayDifferential3f(mi.Ray3f(origin, d)))
    return color.numpy().T.astype(float).reshape(len(directions), count, 3)
