"""What f does outside of a box that shall hold its surface: one sign, as a proof; two signs, as a proof; or neither.

Outward rounded intervals enclose f on cells of the space around the box. A cell without a certain sign is divided; the
cells grow with their distance, so that "everywhere a ray can be" takes few. Two remedies against overestimation
(Moore, Kearfott, Cloud: Introduction to Interval Analysis, 2009, chapter 6): along an axis on which the derivative has a
certain sign only the end of a cell counts, and the mean value form narrows what is left.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from ..numbers import DefinedPart, Dual, OutwardInterval
from .surface import LARGEST_COORDINATE, Box, Surface

BOX_MARGIN = 1e-6  # relative; keeps crossings on the box's own faces, where a sphere touches it, inside
FARTHEST = 100 * LARGEST_COORDINATE  # of a surface's own frame: 64 generations of rays from the rim of the space
MOST_CELLS = 1 << 14  # looked at before the question is left open, of a formula of LONG characters
LONG = 100
MOST_ROUNDS = 64
UNDEFINED_ROUNDS = 4  # for which cells are divided where f is not defined everywhere
PIECES = 64  # of each part of a way on which f is shown to be defined
ON_A_FACE = 17  # points along each side of a face that are looked at where no proof succeeds

Point = tuple[float, float, float]


@dataclass(frozen=True)
class Outside:
    """What is known of f, as it is written, outside of a box and on its faces."""

    sign: int  # +1 or -1: the sign of f, proven wherever it is defined; 0: not proven
    change: tuple[Point, Point] | None = None  # where f > 0 and where f < 0, both outside or on the faces: a proof too
    face: str = ""  # the face on which both points lie, as "x = 0.8"; "" where they lie on none
    defined: bool = True  # everywhere, as a proof


def widened(box: Box) -> Box:
    """`box`, larger by BOX_MARGIN of its sides, as floats."""
    low, high = (np.array(corner, float) for corner in box)
    margin = BOX_MARGIN * (high - low)
    return tuple((low - margin).tolist()), tuple((high + margin).tolist())


def outside(surface: Surface, box: Box, region: Box | None = None, length: int = LONG) -> Outside:
    """What `surface.function` does on the widened `box`'s faces and outside of it, within `region` of its own frame.

    Without a region: wherever a ray can be. `center` and `inside` of the surface do not count. The `length` of a formula
    bounds the effort: a cell of a longer one costs more, and a search of few cells comes to an end sooner.
    """
    alike = surface.model_copy(update={"center": (0.0, 0.0, 0.0), "inside": "negative"})
    most = int(MOST_CELLS * min(1.0, LONG / length) ** 2)
    return _outside(alike, box, region or ((-FARTHEST,) * 3, (FARTHEST,) * 3), most)


@lru_cache(maxsize=4096)
def _outside(surface: Surface, box: Box, region: Box, most: int) -> Outside:
    found = _searched(surface, np.array(widened(box)), np.array(region), most)
    return found if found.sign else _on_a_face(surface, np.array(box)) or found


def _searched(surface: Surface, box: np.ndarray, region: np.ndarray, most: int) -> Outside:
    """The proof by cells, or the first two points of opposite signs that it comes across."""
    cells, faces = _slabs(box, region)
    middle, half = box.mean(axis=0)[:, None], 0.5 * np.ptp(box, axis=0)[:, None]
    seen: dict[int, Point] = {}
    looked_at, loose = 0, set()  # the signs of cells where f is defined in part, 0 of those where it is not
    for number in range(MOST_ROUNDS):
        if not cells.shape[-1]:
            sign = next(iter(seen), 0)
            return Outside(0 if loose - {sign, 0} else sign, defined=not loose)
        looked_at += cells.shape[-1]
        points = _nearest(cells, faces)
        low, high, certain, rising = _enclosed(surface, cells, points, derivatives=number > 0)
        for sign, of_cells, of_points in ((1, low > 0, certain == 1), (-1, high < 0, certain == -1)):
            where = np.flatnonzero(of_cells | of_points)
            if len(where):
                seen.setdefault(sign, tuple(points[:, where[0]].tolist()))
        if len(seen) == 2:
            pair = seen[1], seen[-1]
            return Outside(0, pair if _is_defined_between(surface, box, *pair) else None)
        left = ~((low > 0) | (high < 0))
        if number:
            left[left] = ~_signed_where_defined(surface, cells[..., left], loose)
        if number >= UNDEFINED_ROUNDS:  # no proof any more, but perhaps two signs elsewhere
            defined = np.isfinite(low) & np.isfinite(high)
            if np.any(left & ~defined):
                loose |= {1, -1}
            left &= defined
        if looked_at + 4 * np.count_nonzero(left) > most:
            break
        cells, faces = _divided(cells[..., left], faces[left], rising[:, left], middle, half)
    return Outside(0)


def _slabs(box: np.ndarray, region: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The region without the box as six slabs (2, 3, n), and for each its axis, + 3 on the upper side of the box."""
    cells, faces, rest = [], [], region.astype(float)
    for axis in range(3):
        for side, (start, stop) in enumerate(((rest[0, axis], min(box[0, axis], rest[1, axis])),
                                              (max(box[1, axis], rest[0, axis]), rest[1, axis]))):
            if start < stop:
                slab = rest.copy()
                slab[:, axis] = start, stop
                cells.append(slab)
                faces.append(axis + 3 * side)
        rest[0, axis], rest[1, axis] = max(rest[0, axis], box[0, axis]), min(rest[1, axis], box[1, axis])
        if rest[0, axis] >= rest[1, axis]:
            break  # all of the region lies on one side
    return np.stack(cells, axis=-1) if cells else np.empty((2, 3, 0)), np.array(faces, int)


def _nearest(cells: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """(3, n): the middles of the sides of the cells that face the box."""
    points, each = 0.5 * (cells[0] + cells[1]), np.arange(cells.shape[-1])
    axis, above = faces % 3, faces >= 3
    points[axis, each] = np.where(above, cells[0][axis, each], cells[1][axis, each])
    return points


def _enclosed(surface: Surface, cells, points, derivatives: bool):
    """Bounds (n,) of f on every cell, its sign at `points` where that is certain, and where f is monotone, (3, n)."""
    def value(low, high):
        return OutwardInterval.of(surface.regular_form(*map(OutwardInterval, low, high), **surface.parameters))

    low, high = cells
    rising = np.zeros(low.shape, bool)
    with np.errstate(all="ignore"):
        at = value(points, points)
        sign = np.where(at.low > 0, 1, np.where(at.high < 0, -1, 0))
        if not derivatives:
            f = value(low, high)
            return *(np.broadcast_to(v, sign.shape) for v in (f.low, f.high)), sign, rising
        f = surface.regular_form(*Dual.axes(tuple(map(OutwardInterval, low, high))), **surface.parameters)
        slopes = [OutwardInterval.of(0.0 if d is None else d) for d in f.derivatives]
        up = np.stack([np.broadcast_to(s.low >= 0, sign.shape) for s in slopes])
        down = np.stack([np.broadcast_to(s.high <= 0, sign.shape) for s in slopes])
        rising = up | down
        least = value(np.where(down, high, low), np.where(up, low, high))
        most = value(np.where(up, high, low), np.where(down, low, high))
        mean = at + sum((OutwardInterval(low[k], high[k]) - points[k]) * slopes[k] for k in range(3))
        # a bound that is NaN is none; each of the others holds
        bounds = [np.broadcast_to(v, sign.shape) for v in
                  (np.fmax(np.fmax(f.value.low, least.low), mean.low), np.fmin(np.fmin(f.value.high, most.high), mean.high))]
    return *bounds, sign, rising


def _signed_where_defined(surface: Surface, cells: np.ndarray, loose: set[int]) -> np.ndarray:
    """(n,) whether f has one sign on a cell wherever it is defined there; adds the signs to `loose`."""
    with np.errstate(all="ignore"):
        f = DefinedPart.of(surface.regular_form(*map(DefinedPart, *cells), **surface.parameters))
    signed = np.broadcast_to(f.low > f.high, cells.shape[-1]).copy()  # not defined at all
    if np.any(signed):
        loose.add(0)
    for sign, cells_of_it in ((1, f.low > 0), (-1, f.high < 0)):
        cells_of_it = cells_of_it & ~signed
        if np.any(cells_of_it):
            loose.add(sign)
            signed |= cells_of_it
    return signed


def _divided(cells, faces, rising, middle, half):
    """Every cell cut twice, across its two longest sides; lengths far away count by their logarithm."""
    for _ in range(2):
        place = np.arcsinh((cells - middle) / half)
        length = place[1] - place[0]
        axis, each = np.argmax(np.where(rising, 0.25 * length, length), axis=0), np.arange(cells.shape[-1])
        cut = (middle + half * np.sinh(0.5 * (place[0] + place[1])))[axis, each]
        cut = np.clip(cut, cells[0][axis, each], cells[1][axis, each])
        lower, upper = cells.copy(), cells.copy()
        lower[1, axis, each] = upper[0, axis, each] = cut
        cells, faces, rising = np.concatenate([lower, upper], axis=-1), np.tile(faces, 2), np.tile(rising, 2)
    return cells, faces


def _is_defined_between(surface: Surface, box: np.ndarray, p: Point, q: Point) -> bool:
    """Whether f is defined on a way from p to q that stays outside of `box` or on its faces, so that it has a zero there.

    Every piece of the way keeps a coordinate that lies outside.
    """
    p, q = np.array(p), np.array(q)
    axis_of = lambda v: int(np.argmax(np.maximum(box[0] - v, v - box[1]) / np.ptp(box, axis=0)))
    a, b = axis_of(p), axis_of(q)
    corner = p.copy()
    middle = box[:, a].mean()
    if a != b or (p[a] > middle) == (q[a] > middle):
        corner[b] = q[b] if a != b else p[b]
        way = [p, corner, q]
    else:  # from one side to the one opposite: around
        c = (a + 1) % 3
        corner[c] = box[1, c] + np.ptp(box[:, c])
        around = corner.copy()
        around[a] = q[a]
        way = [p, corner, around, q]
    shares = np.linspace(0, 1, PIECES + 1)
    points = np.concatenate([start + (stop - start) * shares[:, None] for start, stop in itertools.pairwise(way)]).T
    low, high = np.minimum(points[:, :-1], points[:, 1:]), np.maximum(points[:, :-1], points[:, 1:])
    low, high = low - 1e-15 * np.abs(low), high + 1e-15 * np.abs(high)  # the pieces' ends are rounded
    f_low, f_high, _, _ = _enclosed(surface, np.stack([low, high]), points[:, :-1], derivatives=False)
    return bool((np.isfinite(f_low) & np.isfinite(f_high)).all())


def _on_a_face(surface: Surface, box: np.ndarray) -> Outside | None:
    """A change of sign on a face of `box`, widened, between points of a regular grid."""
    steps, wide = np.linspace(0, 1, ON_A_FACE), np.array(widened(box))
    for axis in range(3):
        for side in (0, 1):
            grid = [box[0, k] + (box[1, k] - box[0, k]) * steps for k in range(3)]
            grid[axis] = wide[side, axis:axis + 1]
            points = np.stack([g.ravel() for g in np.meshgrid(*grid, indexing="ij")])
            _, _, sign, _ = _enclosed(surface, np.stack([points, points]), points, derivatives=False)
            if (sign == 1).any() and (sign == -1).any():
                pair = tuple(tuple(points[:, np.flatnonzero(sign == s)[0]].tolist()) for s in (1, -1))
                if _is_defined_between(surface, box, *pair):
                    return Outside(0, pair, f"{'xyz'[axis]} = {box[side, axis]:.6g}")
    return None
