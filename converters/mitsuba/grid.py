"""Any bounded surface as Mitsuba's `sdfgrid`: f on a grid, intersected as its trilinear interpolation.

The interpolation crosses zero O(h^2) away from f, whatever its gradient: f need not be a distance. Normals are
Mitsuba's "smooth" ones, which are as good; its "analytic" ones are O(h).
"""

from __future__ import annotations

import numpy as np

from raytruth.converters.mesh.error import kept
from raytruth.converters.mesh.placed import Placed
from raytruth.reference_tracer.errors import InputError

from .variant import mi

FEWEST, MOST = 8, 384  # cells along a side: more take minutes and gigabytes
LARGEST = 1e30  # fp32 holds it


def grid(placed: Placed, resolution: int) -> tuple[mi.Shape, float | None, float | None]:
    """The surface of `placed`, which must have a region; the largest distance measured between shape and surface, and the
    angle between their normals, in radians, that 99 % of the points looked at keep; None: not measurable.

    A grid must not be turned, so that its axes are the world's. Mitsuba 3.9.1 misses grids with different numbers of
    cells along x and z: there are `resolution` along every side of the box, and one more at each end. Raises InputError
    for a resolution too coarse or too fine.
    """
    if not FEWEST <= resolution <= MOST:
        raise InputError(f"a grid needs a resolution of {FEWEST} to {MOST} cells; found {resolution}")
    corners = placed.corners_in_world()
    low, high = corners.min(axis=0), corners.max(axis=0)
    axes = (low + (high - low) * np.linspace(-1 / resolution, 1 + 1 / resolution, resolution + 3)[:, None]).T
    values = _sampled(placed, axes)
    to_world = np.diag([*(axes[:, -1] - axes[:, 0]), 1.0])
    to_world[:3, 3] = axes[:, 0]
    shape = mi.load_dict({
        "type": "sdfgrid", "normals": "smooth", "to_world": mi.ScalarTransform4f(to_world),
        "grid": mi.TensorXf(np.ascontiguousarray(values.transpose(2, 1, 0)[..., None], np.float32))})  # z, y, x, 1
    return shape, *_errors(placed, shape, values, axes)


def _sampled(placed: Placed, axes: np.ndarray) -> np.ndarray:
    """The regular form at the grid's points, (x, y, z), a slab at a time."""
    slab = np.stack(np.meshgrid([0.0], axes[1], axes[2], indexing="ij"), axis=-1).reshape(-1, 3)
    values = np.empty([len(a) for a in axes])
    for i, x in enumerate(axes[0]):
        slab[:, 0] = x
        values[i] = placed.values(*placed.to_own_frame(slab).T).reshape(values[i].shape)
    return np.clip(values, -LARGEST, LARGEST)


def _errors(placed: Placed, shape: mi.Shape, values: np.ndarray, axes: np.ndarray) -> tuple[float | None, float | None]:
    """The largest distance at the middle of cells that the surface passes through, to first order, and the angle that normals
    keep at 99 % of the hits of rays through them; None where it is not measurable, without a gradient.
    """
    inside = values < 0
    ends = [np.s_[i:i - 1 or None, j:j - 1 or None, k:k - 1 or None] for i in (0, 1) for j in (0, 1) for k in (0, 1)]
    count = sum(inside[end].astype(np.int8) for end in ends)
    crossed = np.nonzero((count > 0) & (count < 8))
    points = np.stack([0.5 * (a[1:] + a[:-1])[i] for a, i in zip(axes, crossed)], axis=1)
    exact, gradients = placed.gradient(placed.to_own_frame(points))
    interpolated = sum(values[end][crossed] for end in ends) / 8
    with np.errstate(all="ignore"):
        largest = float(np.max(np.abs(interpolated - exact) / np.linalg.norm(gradients, axis=1), initial=0.0))
    # in the very middle Mitsuba's normals are better than elsewhere
    cell = np.array([a[1] - a[0] for a in axes])
    turns = _turns(placed, shape, points + np.random.default_rng(0).uniform(-0.5, 0.5, points.shape) * cell, cell.max())
    turn = kept(turns, 0.99, len(turns)) if len(turns) else 0.0
    return tuple(found if np.isfinite(found) else None for found in (largest, turn))


def _turns(placed: Placed, shape: mi.Shape, points: np.ndarray, cell: float) -> np.ndarray:
    """The angles between Mitsuba's normals and grad f where rays against the gradient, that start two cells off `points`
    (n, 3) of the world, meet `shape` within four; infinite ones are not measurable."""
    def out(places):
        _, gradients = placed.gradient(placed.to_own_frame(places))
        with np.errstate(all="ignore"):
            return placed.turned(gradients / np.linalg.norm(gradients, axis=1, keepdims=True))

    normals = out(points)
    usable = np.isfinite(normals).all(axis=1)
    points, normals = points[usable], normals[usable]
    if not len(points):
        return np.full(len(usable), np.inf)
    vectors = lambda kind, v: kind(*(mi.Float(np.ascontiguousarray(c, np.float32)) for c in v.T))
    rays = mi.Ray3f(vectors(mi.Point3f, points + 2 * cell * normals), vectors(mi.Vector3f, -normals), mi.Float(4 * cell),
                    mi.Float(0), mi.Color0f())
    si = mi.load_dict({"type": "scene", "shape": shape}).ray_intersect(rays)
    met = si.is_valid().numpy()
    chord = np.linalg.norm(out(si.p.numpy().T[met].astype(float)) - si.sh_frame.n.numpy().T[met], axis=1)
    with np.errstate(invalid="ignore"):
        angles = np.where(np.isfinite(chord), 2 * np.arcsin(np.minimum(chord / 2, 1)), np.inf)
    return np.concatenate([angles, np.full(np.sum(~usable), np.inf)])
