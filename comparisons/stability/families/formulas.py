"""Families of formulas a user may type: poles, the edge of a square root's domain, values that do not exist."""

from __future__ import annotations

from functools import cache

import numpy as np

from reference_tracer.surfaces.expression import Expression

from ..family import About, Shape, SurfaceFamily
from ..law import Law
from ..rays import Draw, Rays

STEP = 0.05


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


FAMILIES = (
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
