"""How far a mesh is from its surface: bounds that hold, or none at all.

At a point the distance is bounded by a bracket: where outward rounded intervals give f opposite signs at p - r n and
p + r n, and f is defined in between, the surface passes within r of p (intermediate value theorem). Points looked at are
the centroids of the triangles and the middles of their edges; between them the distance is that of the parabola through
them, to the third order in the size of a triangle. At the same points interpolated normals are held against grad f.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from raytruth.reference_tracer.numbers import Interval, OutwardInterval

from .placed import CHUNK, Placed

SPARE = 1 + 1e-3  # of the first guess |f| / |grad f|, which is exact to first order
ROUNDING = 2.0**-51  # of a coordinate: no bracket is narrower
GROWTH = (1.05, 1.25, 2.0, *[4.0] * 26)  # from a bracket to the next, until one shows a change of sign
HALVINGS = 5  # of the way back from a bracket that shows it to the last one that did not


def bounds(placed: Placed, points: np.ndarray, facets: np.ndarray) -> np.ndarray:
    """Upper bounds of the distances (n,) of `points` (n, 3), in the surface's own frame; infinity where none is shown.

    Brackets lie along the gradient; along `facets` (n, 3), unit normals, where there is none or it shows nothing.
    """
    found = np.full(len(points), np.inf)
    for start in range(0, len(points), CHUNK):
        part = slice(start, start + CHUNK)
        found[part] = _bracketed(placed, points[part], facets[part])
    return found


def _bracketed(placed: Placed, points, facets):
    values, gradients = placed.gradient(points)
    with np.errstate(all="ignore"):
        length = np.linalg.norm(gradients, axis=1)
        normals, guess = gradients / length[:, None], np.abs(values) / length
    size = 1 + np.abs(points).max(axis=1, initial=0)
    least, usable = ROUNDING * size, np.isfinite(normals).all(axis=1) & (guess < size)
    found = np.full(len(points), np.inf)
    for n, able in ((normals, usable), (facets, np.isfinite(facets).all(axis=1))):
        left = np.flatnonzero(able & np.isinf(found))
        r = np.maximum(SPARE * np.where(usable, guess, 0), least)
        too_narrow = np.zeros(len(points))
        late = []
        for number, growth in enumerate(GROWTH):
            if not len(left):
                break
            shown = _changes(placed, points[left], n[left] * r[left, None])
            found[left[shown]] = r[left[shown]]
            late.append(left[shown] if number else left[:0])
            left = left[~shown]
            too_narrow[left] = r[left]
            r[left] *= growth
        late = np.concatenate(late) if late else left
        for _ in range(HALVINGS if len(late) else 0):
            r = np.sqrt(too_narrow[late] * found[late])
            shown = _changes(placed, points[late], n[late] * r[:, None])
            found[late[shown]], too_narrow[late[~shown]] = r[shown], r[~shown]
    return found


def _changes(placed: Placed, points, way) -> np.ndarray:
    """Whether f provably changes sign on the way from `points` - `way` over `points` to `points` + `way`, and is defined."""
    a, b = points - way, points + way
    before, after = _sign(placed, a), _sign(placed, b)
    changes = before * after < 0
    alike = before * after > 0
    if alike.any():  # both ends may lie beyond a thin part, or a hollow
        changes[alike] = before[alike] * _sign(placed, points[alike]) < 0
    if placed.surface.degree is None and changes.any():  # else f is a polynomial, and has no poles
        along = _enclosed(placed, np.minimum(a, b)[changes], np.maximum(a, b)[changes], Interval)
        changes[changes] = np.isfinite(along.low) & np.isfinite(along.high)
    return changes


def _sign(placed: Placed, points) -> np.ndarray:
    """The sign of f (n,), a proof; 0 where it is not certain."""
    f = _enclosed(placed, points, points, OutwardInterval)
    return np.where(f.low > 0, 1, np.where(f.high < 0, -1, 0))


def _enclosed(placed: Placed, low, high, number: type[Interval]):
    with np.errstate(all="ignore"):
        return number.of(placed.surface.regular(*(number(low[:, k].copy(), high[:, k].copy()) for k in range(3))))


def of_triangles(placed: Placed, vertices, faces) -> np.ndarray:
    """Upper bounds (5 k,) of the distances of the triangles' points from the surface; infinite ones are not measurable.

    `vertices` in the surface's own frame. Four bounds a triangle, at its centroid and the middles of its edges, and a
    fifth where the parabola through those is highest. [0] without faces.
    """
    if not len(faces):
        return np.zeros(1)
    a, b, c = vertices[faces.T]
    normals = np.cross(b - a, c - a)
    with np.errstate(all="ignore"):
        normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    looked_at = bounds(placed, np.concatenate([(b + c) / 2, (c + a) / 2, (a + b) / 2, (a + b + c) / 3]),
                       np.tile(normals, (4, 1))).reshape(4, -1)
    return np.concatenate([looked_at.ravel(), _between(*looked_at[:3])])


def of_normals(placed: Placed, vertices, normals, faces) -> np.ndarray:
    """The angles (4 k,), in radians, between grad f and the `normals` interpolated at the triangles' centroids and the
    middles of their edges; infinite ones are not measurable. [0] without faces.

    All in the surface's own frame. grad f off the surface is that of the surface nearby to second order.
    """
    if not len(faces):
        return np.zeros(1)
    between = lambda corners: np.concatenate([corners[1] + corners[2], corners[2] + corners[0], corners[0] + corners[1],
                                              2 / 3 * corners.sum(axis=0)]) / 2
    _, gradients = placed.gradient(between(vertices[faces.T]))
    interpolated = between(normals[faces.T])
    with np.errstate(all="ignore"):
        chord = np.linalg.norm(interpolated / np.linalg.norm(interpolated, axis=1, keepdims=True)
                               - gradients / np.linalg.norm(gradients, axis=1, keepdims=True), axis=1)
    return np.where(np.isfinite(chord), 2 * np.arcsin(np.minimum(chord / 2, 1)), np.inf)


def kept(errors: np.ndarray, share: float, points: int) -> float:
    """The error that `share` of all `points` keep; `errors` are those of the worst triangles' points."""
    beyond = int((1 - share) * points)
    return float(np.partition(errors, -1 - beyond)[-1 - beyond]) if beyond < len(errors) else float(errors.min())


def largest(errors: Iterable[float | None]) -> float | None:
    """The error of several meshes together: None, not measurable, if that of one is; 0 of none at all."""
    errors = list(errors)
    return None if None in errors else max(errors, default=0.0)


def worst(vertices, faces, normals, most: int) -> np.ndarray:
    """The `most` faces whose corners' normals turn most on the way along an edge, by the sag that this stands for."""
    if len(faces) <= most:
        return faces
    sag = np.zeros(len(faces))
    for i, j in ((0, 1), (1, 2), (2, 0)):
        way, turn = (array[faces[:, i]] - array[faces[:, j]] for array in (vertices, normals))
        sag = np.maximum(sag, np.abs(np.einsum("ij,ij->i", way, turn)))
    sag[np.isnan(sag)] = np.inf
    return faces[np.argpartition(sag, -most)[-most:]]


def _between(p, q, r) -> np.ndarray:
    """The largest value inside a triangle of the quadratic that is p, q, r at its edges' middles and 0 at its corners.

    4 (p v w + q w u + r u v) in barycentric coordinates is stationary at u : v : w = p (q + r - p) : q (r + p - q) :
    r (p + q - r); where that point lies outside of the triangle the largest value is on an edge, at its middle.
    """
    with np.errstate(all="ignore"):
        weights = np.stack([p * (q + r - p), q * (r + p - q), r * (p + q - r)])
        u, v, w = weights / weights.sum(axis=0)
        inside = 4 * (p * v * w + q * w * u + r * u * v)
    return np.where((weights > 0).all(axis=0) & np.isfinite(inside), inside, np.fmax(np.fmax(p, q), r))
