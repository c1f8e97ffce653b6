"""Marching cubes on the bricks of a grid that a surface passes through.

The volume is cut into bricks; interval arithmetic leaves out those the surface does not meet, so that time and memory
grow with the area of the surface, not with the volume of its box. Neighbouring bricks share a layer of grid points and
therefore the vertices on it, which are welded by the grid edge they lie on.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from skimage.measure import marching_cubes

from raytruth.reference_tracer.errors import InputError

from .occupied import may_hold
from .placed import Placed

BRICK = 32  # cells along the side of a brick
MOST_TRIANGLES = 8_000_000  # about 2 GB with derivatives
MOST_CELLS_ALONG = 4096
FLATTEST = 8  # a side shorter than the longest by more than this gets flat cells, so that a thin disc is not lost
TINY = 1e-30  # fp32 holds it
NODE, INNER = 3, 4  # beside the axes 0, 1, 2 of the grid edge a vertex lies on


@dataclass(frozen=True)
class Grid:
    """Cells that cover a box with at least one to spare on every side: cubes, unless a side is very short."""

    low: np.ndarray  # (3,)
    cell: np.ndarray  # (3,) sides of a cell
    counts: tuple[int, int, int]  # cells along x, y, z

    @staticmethod
    def over(box: np.ndarray, resolution: int) -> Grid:
        extent = box[1] - box[0]
        cell = np.minimum(extent.max(), FLATTEST * extent) / resolution
        counts = np.ceil(extent / cell - 1e-9).astype(int) + 2
        # the shift keeps grid points off the symmetry planes, where f is exactly zero and cells degenerate
        low = box[0] - 0.5 * (counts * cell - extent) + np.array([0.1373, 0.1117, 0.1571]) * cell
        return Grid(low, cell, tuple(counts.tolist()))

    def bricks(self, placed: Placed) -> np.ndarray:
        """(b, 3): the first cell of every brick that the surface may pass through."""
        starts = [np.arange(0, n, BRICK) for n in self.counts]
        stops = [np.minimum(s + BRICK, n) for s, n in zip(starts, self.counts)]
        at = lambda cells: np.ix_(*(self.low[k] + c * self.cell[k] for k, c in enumerate(cells)))
        held = np.nonzero(may_hold(placed, at(starts), at(stops)))
        return np.stack([starts[k][held[k]] for k in range(3)], axis=1)


def march(placed: Placed, box: np.ndarray, resolution: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Vertices (n, 3) near f = 0 in the surface's own frame, faces (m, 3) wound outward, and the sides (3,) of a cell.

    Raises InputError where the mesh would not fit into memory, or where no grid point lies inside although the surface
    may be there.
    """
    if resolution > MOST_CELLS_ALONG:
        raise InputError(f"a mesh of {resolution} cells along its longest side is too fine; "
                         f"at most {MOST_CELLS_ALONG} are possible")
    grid = Grid.over(box, resolution)
    bricks = grid.bricks(placed)
    expected = 2 * BRICK**2 * len(bricks)  # a flat sheet makes two triangles in every cell it passes through
    if expected > 2 * MOST_TRIANGLES:
        raise InputError(f"a mesh of {resolution} cells along its longest side would have about {expected:.1g} "
                         f"triangles, more than {MOST_TRIANGLES:,}; choose a smaller resolution or a larger error")
    pieces = [piece for first in bricks if (piece := _piece(placed, grid, first)) is not None]
    if not pieces:
        if len(bricks):
            raise InputError(f"a mesh of {resolution} cells along its longest side finds nothing of a surface that may "
                             "be there; choose a larger resolution, or give the surface tighter bounds")
        return np.empty((0, 3)), np.empty((0, 3), np.int64), grid.cell
    offsets = np.cumsum([0] + [len(v) for v, _ in pieces[:-1]])
    vertices = np.concatenate([v for v, _ in pieces])
    faces = np.concatenate([f.astype(np.int64) + o for (_, f), o in zip(pieces, offsets)])
    if len(faces) > MOST_TRIANGLES:
        raise InputError(f"a mesh of {resolution} cells along its longest side has {len(faces):,} triangles, more than "
                         f"{MOST_TRIANGLES:,}; choose a smaller resolution or a larger error")
    vertices, faces = _welded(vertices, faces, grid)
    return grid.low + vertices * grid.cell, faces, grid.cell


def _piece(placed: Placed, grid: Grid, first: np.ndarray):
    """Vertices, in units of cells of the whole grid, and faces of one brick; None where f does not change sign."""
    stop = np.minimum(first + BRICK, grid.counts)
    axes = [grid.low[k] + np.arange(first[k], stop[k] + 1) * grid.cell[k] for k in range(3)]
    values = np.broadcast_to(placed.values(*np.ix_(*axes)), [len(a) for a in axes])
    # skimage works in fp32; a power of two scales without rounding, so that neighbours still agree on every sign
    largest = np.abs(values[np.isfinite(values)]).max(initial=1e-300)
    volume = np.clip(values * 2.0 ** -np.floor(np.log2(largest)), -1e30, 1e30).astype(np.float32)
    volume[volume == 0] = TINY  # zero counts as outside (decision O1)
    if not volume.min() < 0 < volume.max():
        return None
    vertices, faces, _, _ = marching_cubes(volume, 0.0, gradient_direction="descent")
    return vertices.astype(float) + first, faces


def _welded(vertices, faces, grid: Grid):
    """One vertex for every grid edge that is crossed; triangles that collapse are dropped."""
    cell = np.floor(vertices)
    fractional = vertices != cell
    axis = np.choose(np.minimum(fractional.sum(axis=1), 2), [NODE, fractional.argmax(axis=1), INNER])
    key = np.ravel_multi_index((*cell.astype(np.int64).T, axis), (*(n + 1 for n in grid.counts), 5))
    _, kept, place = np.unique(key, return_index=True, return_inverse=True)
    faces = place.ravel()[faces]
    a, b, c = faces.T
    faces = faces[(a != b) & (b != c) & (c != a)]
    used = np.zeros(len(kept), bool)
    used[faces] = True
    return vertices[kept[used]], (np.cumsum(used) - 1)[faces]
