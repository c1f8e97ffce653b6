"""Families of one ball: how near a miss, how small, how far, how large the numbers of the scene and of f."""

from __future__ import annotations

import math

import numpy as np

from reference_tracer.surfaces.outside import BOX_MARGIN

from ..exact import ball_crossings, rational
from ..family import About, Shape, SurfaceFamily
from ..law import Law
from ..rays import Draw, Rays

STEP = 0.05


def _box(center_x, r, scale):
    r = r * (1 + BOX_MARGIN)
    return (center_x - r, -r, -r), (center_x + r, r, r)


def _f(x, y, z, center_x, r, scale):
    return ((x - center_x) ** 2 + y**2 + z**2 - r * r) * scale


BALL = Shape(_f, degree=2, box=_box)
FORMULA = Shape(_f, degree=2)  # as a user types it, without a box


def _rays(draw: Draw, impact, *, distance=3.0, r=1.0, center_x=0.0, scale=1.0, step=STEP, **more) -> Rays:
    """Rays that pass the centre of a ball at `impact`, from `distance` before it, with the exact answer."""
    o, d = draw.lines(impact, distance, jitter=6 * step)
    r, center_x, scale = (float(draw.stored(v)) for v in (r, center_x, scale))
    o[:, 0] = draw.stored(o[:, 0] + center_x)
    roots = ball_crossings(o, d, [center_x] * len(o), [rational(r) * rational(r)] * len(o))
    ahead = np.where(roots > 0, roots, np.inf)
    settings = {"limit": 2 * distance, "accuracy": 1e-3 if draw.single else 1e-6, "step": step} | more
    return Rays.of(o, d, first=ahead[:, 0], others=roots[:, 1:], center_x=center_x, r=r, scale=scale, **settings)


def _anywhere(draw: Draw, r: float = 1.0):
    """Impact parameters well within a ball of radius r."""
    return draw.uniform(0, 0.9 * r)


def grazing_rate(p: float) -> float | None:
    """1 - chord/h: the chord has length 2 sqrt(1 - (1 - p)^2), the phase of the steps is uniform.

    Newton on the parabola g, from a middle that lies before its vertex, converges to the first root; it does lie there.
    """
    if p < 1e-12:
        return None  # the rounding of the rays themselves decides which of them touch
    return max(0.0, 1 - 2 * math.sqrt(2 * p - p * p) / STEP)


def small_ball_rate(r: float) -> float:
    """Chords 2 r s with s = sqrt(1 - U), U uniform, density 2 s: the mean of max(0, 1 - chord/h)."""
    ratio = 2 * r / STEP
    return 1 - 2 / 3 * ratio if ratio <= 1 else 1 / (3 * ratio**2)


_LONG_CHORDS = Law("paper", "0: chords are longer than the step, Newton uses quotients of f only", lambda p: 0.0)

FAMILIES = (
    SurfaceFamily(
        About("grazing", "Grazing a ball", "1 - impact parameter",
              (1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-8, 1e-10, 1e-12, 1e-14, 1e-16),
              when="A ray cuts the ball in a chord that is shorter than the step.",
              why="Both crossings fall between two samples, which then have the same sign. Below 1e-14 the rounding of "
                  "f is as large as what it has to resolve.",
              instead="A closed form, Descartes' rule or intervals; a proof says where fp64 cannot tell.",
              single=(1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7)),
        BALL, lambda p, draw: _rays(draw, np.full(draw.count, 1 - p)),
        laws=(Law("paper", "1 - chord/h with chord = 2 sqrt(1 - (1 - p)^2)", grazing_rate),)),
    SurfaceFamily(
        About("near-miss", "Just missing a ball", "impact parameter - 1", (1e-3, 1e-6, 1e-9, 1e-12, 1e-14, 1e-15),
              when="A ray passes the ball at a distance near the rounding of f.",
              why="g comes as close to zero as its own rounding error, and may change sign by it.",
              instead="Proofs: they answer \"undecided\" instead of guessing.",
              single=(1e-3, 1e-4, 1e-5, 1e-6, 1e-7)),
        BALL, lambda p, draw: _rays(draw, np.full(draw.count, 1 + p))),
    SurfaceFamily(
        About("small-ball", "A small ball", "radius", (1.0, 0.1, 0.05, 0.025, 0.01, 1e-3, 1e-4, 1e-6),
              when="The solid is smaller than the step.", why="No sample falls inside it.",
              instead="Any method that does not sample; else a step below the size of the smallest detail.",
              single=(1.0, 0.1, 0.025, 0.01, 1e-3)),
        BALL, lambda p, draw: _rays(draw, p * np.sqrt(draw.uniform(0, 1)), r=p,
                                    accuracy=(1e-3 if draw.single else 1e-6) * max(p, 1e-3)),
        laws=(Law("paper", "1 - 4 r / (3 h) for r <= h/2, (h / 2 r)^2 / 3 above: the mean over the ball's disc",
                  small_ball_rate),)),
    SurfaceFamily(
        About("camera-distance", "A camera far away", "distance of the camera", (1e1, 1e2, 1e4, 1e6, 1e8),
              when="The camera is so far away that the rounding of its coordinates reaches the accuracy asked for.",
              why="A point at distance R is rounded by 1e-16 R (fp64) or 6e-8 R (fp32); no method undoes that.",
              instead="Double precision, and a camera within 1e8 times the smallest detail.",
              single=(1e1, 1e2, 1e3, 1e4)),
        BALL, lambda p, draw: _rays(draw, _anywhere(draw), distance=p), laws=(_LONG_CHORDS,)),
    SurfaceFamily(
        About("translated", "f written far from its origin", "distance of the ball from the origin of f",
              (1e1, 1e2, 1e4, 1e6, 1e8),
              when="f holds an offset, as in (x - 10000)^2, that is large against the solid.",
              why="x - R loses the digits of x below 1e-16 R, and so does every point on the ray.",
              instead="Give the object a \"center\": it is subtracted once, from the ray.",
              single=(1e1, 1e2, 1e3, 1e4)),
        FORMULA, lambda p, draw: _rays(draw, _anywhere(draw), center_x=p), laws=(_LONG_CHORDS,)),
    SurfaceFamily(
        About("scaled-scene", "The whole scene scaled", "factor on all lengths, the step included",
              (1.0, 1e3, 1e6, 1e-3, 1e-6, 1e-9),
              when="A scene is so small that tolerances meant for lengths near 1 exceed its details.",
              why="Newton stops at |dt| <= tol max(1, |t|): for a scene of size 1e-9 that is coarse.",
              instead="Build scenes with lengths near 1.", single=(1.0, 1e3, 1e-3, 1e-4)),
        BALL, lambda p, draw: _rays(draw, _anywhere(draw, p), r=p, distance=3 * p, step=STEP * p,
                                    accuracy=(1e-3 if draw.single else 1e-6) * p)),
    SurfaceFamily(
        About("scaled-f", "f multiplied by a constant", "factor",
              (1.0, 1e6, 1e-6, 1e12, 1e-12, 1e100, 1e-100, 1e200, 1e-200),
              when="Products of coefficients overflow or underflow.",
              why="f and 1e200 f have the same zeros, but squares of the coefficients of the latter are infinite.",
              instead="Methods that use only signs and quotients of f, or coefficients divided by the largest.",
              single=(1.0, 1e6, 1e-6, 1e12, 1e-12, 1e25, 1e-25)),
        FORMULA, lambda p, draw: _rays(draw, _anywhere(draw), scale=p), laws=(_LONG_CHORDS,)))
