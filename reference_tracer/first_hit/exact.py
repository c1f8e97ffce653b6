"""The model's truth: for every surface the cheapest method that misses nothing."""

from __future__ import annotations

from .bounded_quadric import BoundedQuadric
from .cascade import Cascade
from .descartes import Descartes
from .interface import FirstHit
from .interval import IntervalMethod
from .linear import Linear
from .quadratic import Quadratic

HIGHEST_DEGREE = 8  # above it the Bernstein coefficients cost more than intervals


def cheapest_exact(degree: int | None, bounded: bool) -> FirstHit:
    """A closed form where f has degree one or two; Descartes' rule for other algebraic surfaces, with interval
    arithmetic on the rays where rounding hides what it needs; interval arithmetic for everything else."""
    if degree is None or degree > HIGHEST_DEGREE:
        return IntervalMethod()
    if degree <= 1:
        return Linear()
    if degree == 2:
        return BoundedQuadric() if bounded else Quadratic()
    return Cascade(Descartes(), IntervalMethod())
