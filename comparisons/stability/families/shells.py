"""Families of q^2 - c with q = x^2 + y^2 + z^2 - 1: walls, near zeros and even roots."""

from __future__ import annotations

import math

import numpy as np

from ..exact import ball_crossings, rational
from ..family import About, Shape, SurfaceFamily
from ..law import Law
from ..outcome import MOST_EVALUATIONS
from ..rays import Draw, Rays

STEP, START = 0.05, 3.0
WIDEST_IMPACT = 0.7

SHELL = Shape(lambda x, y, z, c: (x**2 + y**2 + z**2 - 1) ** 2 - c, degree=4)


def _shell(p: float, draw: Draw, step: float = STEP) -> Rays:
    """|q| = p: two concentric spheres, of radius sqrt(1 + p) and sqrt(1 - p)."""
    p = float(draw.stored(p))
    o, d = draw.lines(draw.uniform(0, WIDEST_IMPACT), START, jitter=6 * STEP)
    zeros, level = np.zeros(len(o)), rational(p)
    outer, inner = (ball_crossings(o, d, zeros, [1 + sign * level] * len(o)) for sign in (1, -1))
    # a tenth of the wall, unless the condition of the root, eps / |g'|, is worse
    accuracy = min(1e-3, max(p / 10, 1e-6 / p)) if draw.single else min(1e-6, max(p / 10, 1e-15 / p))
    return Rays.of(o, d, first=outer[:, 0], others=np.column_stack([inner, outer[:, 1]]), accuracy=accuracy, step=step,
                   c=draw.stored(p * p))


def shell_rate(p: float) -> float | None:
    """1 - w/h, averaged over impact parameters b uniform in [0, B]; w = sqrt(1 + p - b^2) - sqrt(1 - p - b^2).

    The first wall is found if a sample falls into it; from there Newton converges to its outer face as long as w < h,
    because q^2 - p^2 is convex in q and the middle of the step lies outside or in the outer half of the wall.
    """
    area = lambda square: 0.5 * (B * math.sqrt(square - B * B) + square * math.asin(B / math.sqrt(square)))
    B = WIDEST_IMPACT
    widest = math.sqrt(1 + p - B * B) - math.sqrt(1 - p - B * B)
    return None if widest > STEP else 1 - (area(1 + p) - area(1 - p)) / (B * STEP)


def fine_steps_rate(p: float) -> float | None:
    """The wall lies 1.7 to 2.3 away, so 3.4/p to 4.6/p steps of p/2 are needed, and at most 40 evaluations more."""
    return 1.0 if 3.4 / p > MOST_EVALUATIONS else 0.0 if 4.6 / p + 40 < MOST_EVALUATIONS else None


def _never_zero(p: float, draw: Draw) -> Rays:
    o, d = draw.lines(draw.uniform(0, 0.9), 3.0, jitter=6 * STEP)
    return Rays.of(o, d, first=np.inf, step=STEP, c=-draw.stored(p * p))


def _even_root(p: float, draw: Draw) -> Rays:
    """q^2 touches zero where the ray meets the unit sphere, and never changes sign (decision M1)."""
    o, d = draw.lines(np.full(draw.count, 1 - p), 3.0, jitter=6 * STEP)
    touching = ball_crossings(o, d, np.zeros(len(o)), [rational(1.0)] * len(o))
    return Rays.of(o, d, first=np.inf, others=touching, step=STEP, c=0.0)


FAMILIES = (
    SurfaceFamily(
        About("thin-shell", "A thin shell", "p in |x^2 + y^2 + z^2 - 1| = p, the thickness of the wall",
              (0.03, 0.01, 1e-3, 1e-4, 1e-6, 1e-8),
              when="A wall is thinner than the step.",
              why="The samples before and behind the wall have the same sign; the far side of the shell is seen.",
              instead="Descartes' rule or intervals; steps below the thickness are slow.",
              single=(0.03, 0.01, 1e-3, 1e-4)),
        SHELL, _shell, laws=(Law("paper", "1 - mean(w)/h with w the wall's length along the ray, where w < h",
                                 shell_rate),)),
    SurfaceFamily(
        About("fine-steps", "A thin shell, steps of half its thickness", "thickness of the wall",
              (0.03, 0.01, 1e-3, 5e-4, 1e-4),
              when="Steps are made as small as the finest detail, so that none is missed.",
              why="The number of steps grows as 1/p, for every ray, whether it meets the detail or not.",
              instead="Descartes' rule or intervals: their steps adapt to the ray."),
        SHELL, lambda p, draw: _shell(p, draw, step=p / 2),
        laws=(Law("paper", f"more than {MOST_EVALUATIONS} evaluations a ray as soon as 3.4/p is more", fine_steps_rate,
                  kinds=("too slow",)),
              Law("paper", "0: every wall is met by a sample, and by its outer half", lambda p: 0.0))),
    SurfaceFamily(
        About("never-zero", "Almost zero, everywhere on a sphere", "p in (x^2 + y^2 + z^2 - 1)^2 + p^2",
              (1e-1, 1e-2, 1e-4, 1e-6, 1e-7, 1e-8),
              when="A double root has just been lifted off zero, by less than coefficients resolve.",
              why="The coefficients of the ray's polynomial are rounded by 1e-16 of the largest: p^2 drowns in that.",
              instead="Evaluate f itself, or intervals; take the polynomial's answer only where its noise allows.",
              single=(1e-1, 1e-2, 1e-3, 1e-4)),
        SHELL, _never_zero),
    SurfaceFamily(
        About("even-root", "A surface that only touches zero", "1 - impact parameter on (x^2 + y^2 + z^2 - 1)^2",
              (0.9, 0.5, 0.1, 1e-2, 1e-4),
              when="f does not change sign at its surface.",
              why="By decision M1 a hit is a change of sign: the surface is invisible, which is right here and "
                  "surprising to whoever typed the formula.",
              instead="Write a formula that changes sign. Methods say \"undecided\" where rounding hides the sign."),
        SHELL, _even_root,
        laws=(Law("paper", "1: no ray ever reports the surface it meets", lambda p: 1.0, kinds=("correct",)),)))
