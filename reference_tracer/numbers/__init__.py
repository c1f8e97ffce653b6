"""The number types on which one function f(x, y, z) is evaluated: duals, intervals, polynomials."""

from .dual import Dual
from .interval import DefinedPart, Interval, OutwardInterval
from .polynomial import NotAlgebraic, OfDegree, Polynomial

__all__ = ["DefinedPart", "Dual", "Interval", "NotAlgebraic", "OfDegree", "OutwardInterval", "Polynomial"]
