"""Families of one root on a line: how steep, how flat, how far."""

from __future__ import annotations

import math

import numpy as np

from reference_tracer.numbers.functions import sqrt

from ..family import About, Shape, SurfaceFamily
from ..law import Law
from ..methods import MAX_ITERATIONS
from ..rays import Draw, Rays

STEP, ACCURACY = 0.05, 1e-6
REACH = 100.0  # of the literal method in the family of the horizon

STEEP = Shape(lambda x, y, z, k: x / sqrt(x**2 * (k * k) + 1))


def _power(x, y, z, three, five, seven):
    """x^m for m = 1, 3, 5, 7: a factor is x^2 where its parameter is 1, and 1 where it is 0."""
    square = x**2
    return x * (square * three + (1 - three)) * (square * five + (1 - five)) * (square * seven + (1 - seven))


POWER = Shape(_power, degree=7)
GROUND = Shape(lambda x, y, z: z, degree=1)


def _steep(p: float, draw: Draw) -> Rays:
    o, d = draw.along_x(-1.37, jitter=STEP)
    return Rays.of(o, d, inside=True, limit=3.0, first=-o[:, 0], step=STEP, k=draw.stored(p / STEP))


def _multiple(m: float, draw: Draw) -> Rays:
    o, d = draw.along_x(-1.37, jitter=STEP)
    return Rays.of(o, d, inside=True, limit=3.0, first=-o[:, 0], accuracy=ACCURACY, step=STEP,
                   three=float(m >= 3), five=float(m >= 5), seven=float(m >= 7))


def multiple_rate(m: float) -> float:
    """Newton on x^m goes from x to (1 - 1/m) x: after its 20 iterations |x0| (1 - 1/m)^20 remains, |x0| < h/2."""
    left = (1 - 1 / m) ** MAX_ITERATIONS
    return max(0.0, 1 - ACCURACY / (left * STEP / 2)) if left else 0.0


def _horizon(p: float, draw: Draw) -> Rays:
    """From height 1 down to the ground z = 0 at sin(elevation) = sin(p) U(0.9, 1.1)."""
    sine, turn = math.sin(p) * draw.uniform(0.9, 1.1), draw.uniform(0, 2 * math.pi)
    level = np.sqrt(1 - sine**2)
    d = draw.stored(np.column_stack([level * np.cos(turn), level * np.sin(turn), -sine]))
    o = np.tile([0.0, 0.0, 1.0], (draw.count, 1))
    first = -1 / d[:, 2]
    return Rays.of(o, d, first=first, limit=1e9, reach=REACH, accuracy=1e-6 * first, step=STEP)


def horizon_rate(p: float) -> float:
    """The share of rays with 1/sin(elevation) beyond the literal method's range."""
    return min(1.0, max(0.0, (1 / (REACH * math.sin(p)) - 0.9) / 0.2))


FAMILIES = (
    SurfaceFamily(
        About("steep", "A steep wall in f", "p = k h in f = x / sqrt(1 + k^2 x^2)",
              (0.5, 1.0, 2.0, 3.0, 4.0, 8.0, 20.0, 100.0, 1e4),
              when="f changes fast near its root and slowly elsewhere, within one step.",
              why="Newton maps u = k x to -u^3: from |u| > 1 it runs away from the root, faster at every iteration.",
              instead="Newton that may not leave the bracket (safeguarded), or a step below 2/k."),
        STEEP, _steep, laws=(Law("paper", "1 - 2/p for p > 2, else 0", lambda p: max(0.0, 1 - 2 / p)),)),
    SurfaceFamily(
        About("multiple-root", "A flat root", "odd multiplicity m of f = x^m", (1.0, 3.0, 5.0, 7.0),
              when="f and its derivative vanish together at the surface.",
              why="Newton's error only shrinks by 1 - 1/m an iteration, so its iterations run out; and f itself is "
                  "zero to all digits within 1e-16^(1/m) of the root.",
              instead="A regular form of f, such as the heart's cube root; bisection guided by signs."),
        POWER, _multiple,
        laws=(Law("paper", "1 - 1e-6 / ((1 - 1/m)^20 h/2): what 20 iterations leave", multiple_rate),)),
    SurfaceFamily(
        About("horizon", "The plane's horizon", "elevation below the horizon, radians",
              (0.5, 0.1, 0.02, 0.012, 0.0105, 0.01, 0.009, 1e-3, 1e-5, 1e-7),
              when="The surface lies beyond the range that stepping can afford (here 100).",
              why="The cost of fixed steps grows with the range, so it has to end somewhere; planes do not.",
              instead="A closed form or intervals, with a range of 1e9 at no cost."),
        GROUND, _horizon, laws=(Law("paper", "the share of rays with height/sin(elevation) > 100", horizon_rate),)))
