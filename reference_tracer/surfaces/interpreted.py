"""A surface whose function is carried out as a program: kernels do not depend on it, so that all such surfaces share them."""

from __future__ import annotations

from functools import lru_cache

from ..numbers.interpreter import Interpreter
from ..numbers.polynomial import NotAlgebraic
from ..numbers.program import Program, Unwritable
from .surface import Surface

HIGHEST_DEGREE = 8  # of polynomials that are kept as such: those of which Descartes' rule is asked (first_hit/exact.py)


@lru_cache(maxsize=1024)
def programs_of(surface: Surface) -> tuple[Program, Program] | None:
    """The programs of the regular and of the polynomial form, an empty one where there is none of low degree; None where the
    interpreter cannot carry out the surface."""
    form, numbers = surface.regular_form, surface.parameters
    function = lambda x, y, z: form(x, y, z, **numbers)
    try:
        return Program.of(function), Program.of(function, polynomial=True) if _is_short(surface) else Program()
    except (Unwritable, NotAlgebraic):
        return None


def _is_short(surface: Surface) -> bool:
    return surface.degree is not None and surface.degree <= HIGHEST_DEGREE


class Interpreted:
    """Stands in the place of `of` where families are made; Descartes' rule is asked first, whatever the function."""

    literal_parameters = False
    degree, bounded_quadric = HIGHEST_DEGREE, False

    def __init__(self, of: Surface, arrays):
        self.of, self.family, self.parameters = of, "interpreted", {}
        regular, polynomial = programs_of(of)
        self.function = self.regular_form = Interpreter(regular, arrays)
        self.polynomial_form = Interpreter(polynomial, arrays, HIGHEST_DEGREE, max(of.degree or 1, 1) if _is_short(of) else 1)
        self.variables = [self.regular_form.variables, self.polynomial_form.variables]

    def __getattr__(self, name: str):
        return getattr(self.of, name)
