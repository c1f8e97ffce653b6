"""User surfaces: f(x, y, z) typed as a formula (formula_parser.py), a tree (formula.py) and never executed as Python."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Annotated, ClassVar, Literal

from pydantic import BeforeValidator, Field, PlainSerializer, StringConstraints, WithJsonSchema, field_validator

from ..numbers.jumps import both_sides
from ..numbers.polynomial import HIGHEST_DEGREE
from .conditioning import drowns
from .exact_polynomial import is_definite
from .formula import LEAST_NORMAL, FormulaError, Node, degree, evaluator, has_jumps, parametrised, written
from .formula_functions import function_named
from .formula_grammar import WORDS
from .formula_parser import LONGEST_FORMULA, VOCABULARY, parse_formula
from .odd_part import odd_part
from .outside import outside
from .surface import Bounds, Finite, Surface

MOST_VALUES = 64
Name = Annotated[str, StringConstraints(pattern="^[A-Za-z_\u0370-\u03ff][A-Za-z0-9_\u0370-\u03ff]{0,31}$")]
# pairs in Python, so that surfaces can be keys; an object in files
Values = Annotated[
    tuple[tuple[Name, Finite], ...], Field(max_length=MOST_VALUES),
    BeforeValidator(lambda given: tuple(given.items()) if isinstance(given, dict) else given),
    PlainSerializer(dict, return_type=dict[str, float]),
    WithJsonSchema({"type": "object", "additionalProperties": {"type": "number"}, "maxProperties": MOST_VALUES})]


@dataclass(frozen=True)
class Forms:
    """What a formula's text is made into: f as written, and its odd part, which is f itself for most formulas.

    The numbers of both are parameters: formulas that differ in numbers alone have one `structure`.
    """

    function: Callable  # (x, y, z, **parameters); a parameter that is not given has the formula's own value
    regular: Callable
    parameters: dict[str, float]
    structure: str
    degree: int | None  # of the function, where it is a polynomial
    regular_degree: int | None
    definite: bool  # the regular form is a polynomial of degree two, with terms of that degree in every direction


@lru_cache(maxsize=1024)
def forms_of(text: str, values: tuple[tuple[str, float], ...] = ()) -> Forms:
    """Raises FormulaError."""
    tree = parse_formula(text, values)
    regular = odd_part(tree)
    shared, numbers = parametrised(tree)
    function, structure = _form(shared, numbers), written(shared)
    if regular == tree:
        form = function
    else:
        shared, more = parametrised(regular, start=len(numbers))
        form, structure = _form(shared, more), f"{structure}, traced as {written(shared)}"
        numbers |= more
    return Forms(function, form, numbers, structure, _degree(tree), _degree(regular), is_definite(regular))


def _form(tree: Node, numbers: dict[str, float]) -> Callable:
    evaluate = evaluator(tree)
    at = lambda x, y, z, **given: evaluate((x, y, z), numbers | given)
    return at if not has_jumps(tree) else lambda x, y, z, **given: both_sides(lambda: at(x, y, z, **given))


def _degree(tree: Node) -> int | None:
    found = degree(tree)
    return None if found is None or found > HIGHEST_DEGREE else found


class Expression(Surface):
    """Any f(x, y, z) the user types, e.g. "x^4 + y^4 + z^4 = 1", with a bounding box if the solid is bounded."""

    type: Literal["expression"] = "expression"
    values: Values = Field(default=(), alias="parameters", description='numbers for names in the formula: {"R": 2}')
    formula: str = Field(max_length=LONGEST_FORMULA, description="f(x, y, z), whose solid is f < 0; f = g and f < g are f - g. "
                                                            f"Written with {VOCABULARY}")
    bounds: Bounds | None = Field(default=None, description="a promise that this box holds the whole surface; it is checked. "
                                                                  "Without it, the surface is unbounded")

    title: ClassVar[str] = "Expression"
    equation: ClassVar[str] = "f(x, y, z) = 0, as typed"
    literal_parameters: ClassVar[bool] = True

    @field_validator("values")
    @classmethod
    def _are_free_names(cls, values):
        for name, value in values:
            if 0 < abs(value) < LEAST_NORMAL:
                raise ValueError(f"{name} is a number too small for double precision; scale the formula")
            if name.lower() in ("x", "y", "z", *WORDS) or function_named(name):
                raise ValueError(f"{name} has another meaning in formulas; give the parameter another name")
        return values

    @field_validator("formula")
    @classmethod
    def _can_be_read(cls, text, info):
        try:
            parse_formula(text, info.data.get("values", ()))
        except FormulaError as error:
            raise ValueError(f"the formula {error}") from None
        return text

    @cached_property
    def _forms(self) -> Forms:
        return forms_of(self.formula, self.values)

    @property
    def function(self):
        return self._forms.function

    @property
    def regular_form(self):
        """The odd part of f, values of a sane size: odd_part.py."""
        return self._forms.regular

    @property
    def parameters(self):
        """The numbers of the formula, c0, c1, ... as they stand there, then those of its regular form where that differs.

        Whole exponents are no parameters.
        """
        return self._forms.parameters

    @property
    def family(self):
        # all that the choice of a method depends on is the same for a whole family
        return f"expression{'' if self.box() else ' without bounds'}: {self._forms.structure}" + (
            ", definite" if self.bounded_quadric else "") + (", drowned" if self.drowns else "")

    @cached_property
    def drowns(self):
        return drowns(self, self.region())

    @property
    def degree(self):
        return self._forms.regular_degree

    @property
    def polynomial_form(self):
        return self.regular_form if self.degree is not None else None

    @property
    def exact_form(self):
        return self.function if self._forms.degree is not None else self.polynomial_form

    @property
    def bounded_quadric(self):
        return self.box() is not None and self._forms.definite

    def region(self):
        return self.bounds.corners if self.bounds else None

    def box(self):
        return self.region() if self.sign_outside else None

    @property
    def sign_outside(self):
        if not self.bounds:
            return 0
        found = outside(self, self.bounds.corners, length=len(self.formula))
        # where f is not defined the literal method sees "outside" (M7): no box around what is inside
        return found.sign if found.defined or found.sign == (-1 if self.inside == "positive" else 1) else 0
