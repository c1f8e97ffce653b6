"""Where a line crosses a surface, from the equations of section 7.1 by hand: independent of the code under test.

Roots come from the quadratic formula, or from numpy.roots polished by Newton steps on the printed equation. `Exact`
answers the oracle's questions (reference_tracer.oracle.literal.Search) from them.
"""

from __future__ import annotations

import numpy as np
from numpy.polynomial import polynomial as P
from scipy.spatial.transform import Rotation


def into_frame(obj, o, d):
    """Origin and direction in the frame of the object's surface, turned by SciPy and not by the core."""
    o = o - np.array(obj.surface.center)
    if obj.rotation is None:
        return o, d
    axis = np.array(obj.rotation.axis) / np.linalg.norm(obj.rotation.axis)
    turn = Rotation.from_rotvec(np.radians(obj.rotation.degrees) * axis).inv()
    return turn.apply(o), turn.apply(d)


def line_crossings(obj, o, d) -> np.ndarray:
    """All t in (-inf, inf) where the lines o + t d change side, sorted, padded with infinity: (n, degree)."""
    o, d = into_frame(obj, o, d)
    s = obj.surface
    match s.type:
        case "plane":
            normal = np.array([s.a, s.b, s.c])
            with np.errstate(divide="ignore", invalid="ignore"):
                t = -(o @ normal) / (d @ normal)
            return np.where(np.isfinite(t), t, np.inf)[:, None]
        case "sphere" | "ellipsoid":
            axes = np.full(3, s.r) if s.type == "sphere" else np.array([s.a, s.b, s.c])
            o, d = o / axes, d / axes
            return _quadratic(_dot(d, d), _dot(o, d), _dot(o, o) - 1)
        case "paraboloid":
            scale = np.array([1 / s.a**2, 1 / s.b**2, 0])
            return _quadratic(_dot(d * d, scale), _dot(o * d, scale) - d[:, 2] / 2, _dot(o * o, scale) - o[:, 2])
        case "torus":
            return _polished(_torus_quartics(o, d, s.R, s.r), lambda p, v: _torus(p, v, s.R, s.r), o, d)
        case "heart":
            return _polished(_heart_sextics(o, d), _heart, o, d)
    raise NotImplementedError(s.type)


def first_after_start(crossings, inside, far_inside=False) -> np.ndarray:
    """The first crossing of each ray that starts at t = 0 on the known side `inside`; infinity where there is none.

    Sides alternate along a line, which comes from far away on the side `far_inside`. The number of crossings behind
    the start therefore has a known parity; of the numbers with that parity the one is taken that moves crossings
    least across t = 0. A ray that starts on a surface is decided by its side, not by the sign of a rounding error.
    """
    n, most = crossings.shape
    behind = np.concatenate([np.full((n, 1), -np.inf), crossings, np.full((n, 1), np.inf)], axis=1)
    best, first = np.full(n, np.inf), np.full(n, np.inf)
    for k in range(most + 1):
        moved = np.maximum(0, behind[:, k]) + np.maximum(0, -behind[:, k + 1])
        side = far_inside ^ (k % 2 == 1)
        better = (side == inside) & (moved < best)
        best, first = np.where(better, moved, best), np.where(better, behind[:, k + 1], first)
    return first


class Exact:
    """The model's truth for scenes of planes, quadrics and tori (reference_tracer.oracle.literal.Search)."""

    def __init__(self, scene):
        self.scene = scene

    def first_hit(self, o, d, inside, limit):
        t = np.stack([first_after_start(line_crossings(obj, o, d), inside[:, k], self._far(obj, d))
                      for k, obj in enumerate(self.scene.objects)], axis=-1)
        index = np.argmin(t, axis=-1)
        t = np.maximum(t[np.arange(len(t)), index], 0)
        met = t <= limit
        return np.where(met, t, np.inf), np.where(met, index, -1), t

    def transmittance(self, o, d, inside, distance):
        intensity = np.ones(len(o))
        for k, obj in enumerate(self.scene.objects):
            if not obj.shadow or (self.scene.tracing.shadows == "opaque_only" and obj.material.transparency > 0):
                continue  # decision F3
            crossings = line_crossings(obj, o, d)
            first = first_after_start(crossings, inside[:, k], self._far(obj, d))
            count = np.sum((crossings >= first[:, None]) & (crossings < distance[:, None]), axis=-1)
            intensity *= obj.material.transparency ** count
        return intensity

    @staticmethod
    def _far(obj, d):
        """Whether a line comes from inside: it does where it leaves a half-space or falls out of a paraboloid."""
        s = obj.surface
        local = into_frame(obj, np.zeros_like(d), d)[1]
        far = np.zeros(len(d), bool)
        if s.type == "plane":
            far = local @ np.array([s.a, s.b, s.c]) > 0
        if s.type == "paraboloid":  # along its axis it has one crossing, else both ends of the line are outside
            far = (local[:, 0] == 0) & (local[:, 1] == 0) & (local[:, 2] < 0)
        return far ^ (s.inside == "positive")


def _dot(a, b):
    return np.sum(a * b, axis=-1)


def _quadratic(a, half_b, c) -> np.ndarray:
    """The simple roots of a t^2 + 2 half_b t + c, in the form that does not cancel; infinity where there are none."""
    discriminant = half_b**2 - a * c
    with np.errstate(all="ignore"):
        q = -(half_b + np.where(half_b < 0, -1, 1) * np.sqrt(discriminant))
        roots = np.sort(np.stack([np.where(a == 0, np.inf, q / a), c / q], axis=-1), axis=-1)
    return np.where(discriminant[:, None] > 0, roots, np.inf)


def _torus_quartics(o, d, R, r):
    """(|p|^2 + R^2 - r^2)^2 - 4 R^2 (x^2 + y^2), which has the zeros of the printed form where r < R."""
    for p, v in zip(o, d):
        square = np.array([p @ p + R**2 - r**2, 2 * (p @ v), v @ v])
        flat = np.array([p[:2] @ p[:2], 2 * (p[:2] @ v[:2]), v[:2] @ v[:2]])
        yield P.polysub(P.polymul(square, square), 4 * R**2 * flat)


def _torus(p, v, R, r):
    """g and g' of the printed form."""
    rho = np.hypot(p[..., 0], p[..., 1])
    slope = 2 * (rho - R) * (p[..., 0] * v[..., 0] + p[..., 1] * v[..., 1]) / rho + 2 * p[..., 2] * v[..., 2]
    return (rho - R)**2 + p[..., 2]**2 - r**2, slope


def _heart_sextics(o, d):
    for p, v in zip(o, d):
        x, y, z = (np.array([p[k], v[k]]) for k in range(3))
        x2, y2, z2 = (P.polymul(c, c) for c in (x, y, z))
        a = P.polysub(P.polyadd(P.polyadd(x2, 9 / 4 * z2), y2), [1])
        b = P.polymul(P.polyadd(x2, 9 / 80 * z2), P.polymul(y2, y))
        yield P.polysub(P.polymul(a, P.polymul(a, a)), b)


def _heart(p, v):
    x, y, z = np.moveaxis(p, -1, 0)
    dx, dy, dz = np.moveaxis(v, -1, 0)
    a, b = x**2 + 9 / 4 * z**2 + y**2 - 1, x**2 + 9 / 80 * z**2
    slope = (3 * a**2 * (2 * x * dx + 9 / 2 * z * dz + 2 * y * dy)
             - 3 * y**2 * dy * b - y**3 * (2 * x * dx + 9 / 40 * z * dz))
    return a**3 - y**3 * b, slope


def _polished(coefficients, g, o, d) -> np.ndarray:
    """The real roots of each polynomial after two Newton steps on g; pairs closer than 1e-6 are left to the caller."""
    rows = [np.sort(c.real[np.abs(c.imag) < 1e-9 * np.maximum(1, np.abs(c))])
            for c in (np.roots(polynomial[::-1]) for polynomial in coefficients)]
    t = np.full((len(rows), max(map(len, rows), default=0)), np.inf)
    for row, roots in zip(t, rows):
        row[:len(roots)] = roots
    for _ in range(2):
        with np.errstate(all="ignore"):
            value, slope = g(o[:, None] + np.where(np.isfinite(t), t, 0)[..., None] * d[:, None], d[:, None])
            t = np.where(np.isfinite(t) & np.isfinite(value / slope), t - value / slope, t)
    return t
