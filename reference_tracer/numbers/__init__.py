"""The number types on which one function f(x, y, z) is evaluated: duals, intervals, polynomials."""

from .dual import Dual
from .interval import Interval, OutwardInterval
from .polynomial import NotAlgebraic, Polynomial

__all__ = ["Dual", "Interval", "NotAlgebraic", "OutwardInterval", "Polynomial"]
