"""Families of one root on a line: how steep, flat or far; where f has a pole, no value, or no gradient."""

from __future__ import annotations

import math
from functools import cache

import numpy as np

from raytruth.reference_tracer.numbers.functions import sqrt
from raytruth.reference_tracer.surfaces.expression import Expression
from raytruth.reference_tracer.surfaces.heart import Heart
from raytruth.reference_tracer.surfaces.torus import Torus

from ..exact import crossings
from ..family import About, Draw, Law, Rays, Shape, SurfaceFamily, unit
from ..methods import MAX_ITERATIONS

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


# --- formulas a user may type -----------------------------------------------------------------------------------------
@cache
def _typed(formula: str) -> Shape:
    """The formula as the scene format parses it. The difficulty is the coordinate y of the whole ray: data, too."""
    surface = Expression(type="expression", formula=formula)
    return Shape(surface.function, degree=surface.degree)


def _along_x(draw: Draw, p: float, sign: float):
    o, d = draw.along_x(-1.37 * sign, jitter=STEP, sign=sign)
    o[:, 1] = draw.stored(p)
    return o, d


def _pole(p: float, draw: Draw) -> Rays:
    o, d = _along_x(draw, p, 1.0)
    return Rays.of(o, d, inside=True, limit=4.0, first=np.inf if p == 0 else 1 / p - o[:, 0], step=STEP)


def pole_rate(p: float) -> float | None:
    """The step across the pole changes sign. Newton on 1/x - p goes from x to 2 x - p x^2: right from 0 < x < 2/p.

    Its middle lies at x = s - h/2, the sample s behind the pole at 0 < s < min(h, 1/p), or nothing is seen at all.
    """
    if p == 0:
        return 1.0
    return 1 - max(0.0, min(STEP, 1 / p, 2 / p + STEP / 2) - STEP / 2) / STEP


def _edge(p: float, draw: Draw) -> Rays:
    o, d = _along_x(draw, p, -1.0)
    return Rays.of(o, d, limit=3.0, first=o[:, 0] - p, step=STEP, accuracy=min(1e-6, 1e-2 * p))


def edge_rate(p: float) -> float:
    """A sample s must fall between the root p and the edge 0, where f < 0; beyond the edge f is NaN, "outside".

    Newton on sqrt(x) - sqrt(p) goes from x to sqrt(x) (2 sqrt(p) - sqrt(x)), out of the domain if x > 4 p; its middle
    is s + h/2.
    """
    return 1 - max(0.0, min(p, 4 * p - STEP / 2, STEP)) / STEP


def _gap(p: float, draw: Draw) -> Rays:
    o, d = _along_x(draw, p, 1.0)
    return Rays.of(o, d, inside=True, limit=3.0, first=np.nan, step=STEP)


# --- points where the gradient vanishes or does not exist -------------------------------------------------------------
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
        GROUND, _horizon, laws=(Law("paper", "the share of rays with height/sin(elevation) > 100", horizon_rate),)),
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
        SPINDLE, _axis),
    SurfaceFamily(
        About("pole", "A pole beside a root", "p in f = 1/x - p, whose pole is at 0 and root at 1/p",
              (0.0, 1.0, 4.0, 10.0, 20.0, 30.0, 100.0, 1000.0),
              when="f jumps from minus to plus infinity on the way.",
              why="Signs change at a pole as they do at a root; a method that trusts signs reports a surface there.",
              instead="Multiply the formula by its denominator. \"Undecided\" is an honest answer (decision M7)."),
        _typed("1/x - y"), _pole,
        laws=(Law("paper", "1 for p = 0; else 1 - max(0, min(h, 1/p) - h/2) / h: Newton finds the root by accident",
                  pole_rate),)),
    SurfaceFamily(
        About("domain-edge", "A root at the edge of a square root", "p in f = sqrt(x) - sqrt(p), root at p, edge at 0",
              (0.2, 0.05, 0.02, 0.01, 0.0075, 1e-3, 1e-4, 1e-6),
              when="The surface lies within a step of the place where f stops existing.",
              why="The sample beyond the edge is NaN, which counts as outside (decision M7): no change of sign. And "
                  "Newton on a square root overshoots the edge and cannot come back.",
              instead="Intervals: they divide until a segment lies within the domain."),
        _typed("sqrt(x) - sqrt(y)"), _edge,
        laws=(Law("paper", "1 - min(p, 4 p - h/2, h) / h: a sample between root and edge, and a middle within 4 p",
                  edge_rate),)),
    SurfaceFamily(
        About("undefined-gap", "A stretch without values", "half width of the gap |x| < p of f = 2 x + sqrt(x^2 - p^2)",
              (0.5, 0.1, 1e-2, 1e-4, 1e-8),
              when="f does not exist on part of the ray; it has no zero, but different signs on both sides.",
              why="The literal method takes NaN for outside and cannot tell a jump from a root.",
              instead="A method that answers \"undecided\" (decision M7): it is the only right answer here."),
        _typed("2*x + sqrt(x**2 - y**2)"), _gap,
        laws=(Law("paper", "1: a definite answer on every ray", lambda p: 1.0),)))
