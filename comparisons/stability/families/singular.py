"""Families at points where the gradient vanishes or does not exist: the heart's belt and tips, the torus's axis."""

from __future__ import annotations

import numpy as np

from reference_tracer.surfaces.heart import Heart
from reference_tracer.surfaces.torus import Torus

from ..exact import crossings
from ..family import About, Shape, SurfaceFamily
from ..rays import Draw, Rays, unit

LIMIT = 6.0
HEART = Shape(Heart.f, degree=6, regular=Heart.f_regular, box=lambda: Heart().box())
SPINDLE = Shape(Torus.f)


def _heart(o, d) -> Rays:
    every = [crossings(Heart.f, a, b, LIMIT) for a, b in zip(o, d)]
    most = max(map(len, every), default=0)
    table = np.array([t + [np.inf] * (most + 1 - len(t)) for t in every])
    return Rays.of(o, d, first=table[:, 0], others=table[:, 1:], limit=LIMIT)


def _belt(p: float, draw: Draw) -> Rays:
    """Towards points of the ellipse x^2 + 9/4 z^2 = 1, shifted to y = p, along its normal in that plane."""
    turn, level = draw.uniform(0, 2 * np.pi), np.full(draw.count, p)
    target = np.column_stack([np.cos(turn), level, np.sin(turn) * 2 / 3])
    normal = unit(np.column_stack([np.cos(turn), 0 * level, np.sin(turn) * 1.5]))
    return _heart(target + normal * (2.3 + draw.uniform(0, 0.05)[:, None]), -normal)


def _tips(p: float, draw: Draw) -> Rays:
    """From outside, above one of the tips (0, +-1, 0), towards points at a distance of about p from it."""
    up = draw.random.choice([-1.0, 1.0], draw.count)
    target = np.column_stack([p * draw.random.normal(size=draw.count), up, p * draw.random.normal(size=draw.count)])
    away = draw.directions()
    away[:, 1] = np.abs(away[:, 1]) * up
    o = target + away * 2.3
    return _heart(o, unit(target - o))


def _axis(p: float, draw: Draw) -> Rays:
    """Parallel to the axis of a torus with r > R, p beside it: z^2 = r^2 - (p - R)^2."""
    turn = draw.uniform(0, 2 * np.pi)
    o = np.column_stack([p * np.cos(turn), p * np.sin(turn), 3 - draw.uniform(0, 0.05)])
    d = np.tile([0.0, 0.0, -1.0], (draw.count, 1))
    height = np.sqrt(1 - (np.hypot(o[:, 0], o[:, 1]) - 0.5) ** 2)
    return Rays.of(o, d, first=o[:, 2] - height, others=o[:, 2] + height, limit=LIMIT, R=0.5, r=1.0)


FAMILIES = (
    SurfaceFamily(
        About("heart-belt", "The heart's belt", "distance from the ellipse y = 0 on which grad f = 0",
              (1e-1, 1e-2, 1e-4, 1e-6, 1e-8, 0.0),
              when="A ray meets the heart near y = 0.",
              why="f has a triple root there: Newton's iterations run out, and f is zero to all digits around it.",
              instead="The form A - y cbrt(B) of decision O5, which has the same zeros and a gradient."),
        HEART, _belt),
    SurfaceFamily(
        About("heart-tips", "The heart's two tips", "distance from the point (0, 1, 0) or (0, -1, 0)",
              (1e-1, 1e-2, 1e-4, 1e-6),
              when="A ray meets the heart near the dimple or the tip.",
              why="The surface is a cusp: sheets lie closer than a step, and no gradient exists at the point itself.",
              instead="Methods that keep their bracket; the point itself stays without a normal."),
        HEART, _tips),
    SurfaceFamily(
        About("torus-axis", "Along the axis of a torus", "distance of the ray from the axis",
              (1e-1, 1e-2, 1e-4, 1e-8, 1e-12, 0.0),
              when="A ray runs exactly on the axis of a torus that overlaps itself.",
              why="sqrt(x^2 + y^2) has no derivative there: Newton divides by NaN and stays in the middle of its step.",
              instead="Methods that can go on without the derivative; decision O4 reports the missing normal."),
        SPINDLE, _axis))
