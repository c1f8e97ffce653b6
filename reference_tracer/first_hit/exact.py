"""The model's truth: for every surface the cheapest method that misses nothing."""

from __future__ import annotations

from .cascade import Cascade
from .descartes import Descartes
from .interval import IntervalMethod
from .quadratic import Quadratic

HIGHEST_DEGREE = 8  # above it the Bernstein coefficients cost more than intervals


def cheapest_exact(surface):
    """A closed form where f has degree one or two; Descartes' rule for other algebraic surfaces, with interval
    arithmetic on the rays where rounding hides what it needs; interval arithmetic for everything else."""
    if surface.degree is None or surface.degree > HIGHEST_DEGREE:
        return IntervalMethod()
    if surface.degree <= 2:
        return Quadratic()
    return Cascade(Descartes(), IntervalMethod())
