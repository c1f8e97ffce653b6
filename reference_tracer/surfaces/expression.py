"""User surfaces: f(x, y, z) typed as a formula, parsed here and never executed as Python."""

from __future__ import annotations

import ast
import math
import operator
import warnings
from collections.abc import Callable
from functools import cached_property, lru_cache
from typing import ClassVar, Literal

from pydantic import Field, field_validator

from ..numbers import NotAlgebraic, Polynomial
from ..numbers import functions as fn
from .outside import outside
from .surface import Bounds, Surface

LONGEST_FORMULA = 2000  # characters
MOST_NODES = 500
DEEPEST_NESTING = 60
LARGEST_EXPONENT = 32

FUNCTIONS: dict[str, tuple[Callable, int]] = {
    "sqrt": (fn.sqrt, 1), "cbrt": (fn.cbrt, 1), "sin": (fn.sin, 1), "cos": (fn.cos, 1), "tan": (fn.tan, 1),
    "exp": (fn.exp, 1), "log": (fn.log, 1), "abs": (fn.absolute, 1), "min": (fn.minimum, 2), "max": (fn.maximum, 2)}
OPERATORS: dict[type, Callable] = {ast.Add: operator.add, ast.Sub: operator.sub, ast.Mult: operator.mul,
                                   ast.Div: operator.truediv}
VARIABLES = ("x", "y", "z")
VOCABULARY = "x y z, numbers, + - * / **, and " + " ".join(FUNCTIONS)

Evaluator = Callable[[tuple], object]


class FormulaError(ValueError):
    """A formula that is not one, told in one sentence."""


class _Compiler:
    """Turns a parsed formula into nested functions of the point (x, y, z); anything outside the vocabulary is refused."""

    def __init__(self):
        self.nodes = 0

    def compile(self, node: ast.expr, depth: int = 0) -> Evaluator:
        evaluate = self._translate(node, depth)
        if isinstance(node, (ast.BinOp, ast.Call)) and not _variables(node):
            value = _value(evaluate)  # once, and as IEEE arithmetic has it
            return lambda p: value
        return evaluate

    def _translate(self, node: ast.expr, depth: int) -> Evaluator:
        self.nodes += 1
        if self.nodes > MOST_NODES:
            raise FormulaError(f"has more than {MOST_NODES} operations; write it shorter")
        if depth > DEEPEST_NESTING:
            raise FormulaError(f"is nested deeper than {DEEPEST_NESTING} levels; write it flatter")
        match node:
            case ast.Constant(value=bool()):
                pass
            case ast.Constant(value=int() | float()):
                value = self._number(node.value)
                return lambda p: value
            case ast.Name(id=name) if name in VARIABLES:
                return operator.itemgetter(VARIABLES.index(name))
            case ast.Name(id="pi"):
                return lambda p: math.pi
            case ast.UnaryOp(op=ast.USub(), operand=ast.Constant(value=int() | float() as value)):
                value = -self._number(value)
                return lambda p: value
            case ast.UnaryOp(op=ast.USub(), operand=operand):
                inner = self.compile(operand, depth + 1)
                return lambda p: -inner(p)
            case ast.UnaryOp(op=ast.UAdd(), operand=operand):
                return self.compile(operand, depth + 1)
            case ast.BinOp(op=ast.Pow(), left=left, right=right):
                return self._power(left, right, depth)
            case ast.BinOp(left=left, op=op, right=right) if type(op) in OPERATORS:
                a, b, apply = self.compile(left, depth + 1), self.compile(right, depth + 1), OPERATORS[type(op)]
                return lambda p: apply(a(p), b(p))
            case ast.Call(func=ast.Name(id=name), args=arguments, keywords=[]) if name in FUNCTIONS:
                function, arity = FUNCTIONS[name]
                if len(arguments) != arity:
                    raise FormulaError(f"gives {name} {len(arguments)} argument(s); it takes {arity}")
                inner = [self.compile(a, depth + 1) for a in arguments]
                if arity == 1:
                    return lambda p: function(inner[0](p))
                return lambda p: function(inner[0](p), inner[1](p))
        raise FormulaError(f"uses {_describe(node)}, which a formula may not; allowed are {VOCABULARY}")

    @staticmethod
    def _number(value) -> float:
        try:
            number = float(value)
        except OverflowError:
            number = math.inf
        if not math.isfinite(number):
            raise FormulaError("contains a number too large for double precision")
        return number

    def _power(self, left, right, depth) -> Evaluator:
        base, power = self.compile(left, depth + 1), self.compile(right, depth + 1)
        exponent = None if _variables(right) else power(None)
        if exponent is not None and exponent == int(exponent):
            n = int(exponent)
            if abs(n) > LARGEST_EXPONENT:
                raise FormulaError(f"raises to the power {n}; exponents go from -{LARGEST_EXPONENT} to {LARGEST_EXPONENT}")
            return lambda p: base(p) ** n
        return lambda p: fn.exp(fn.log(base(p)) * power(p))


def _variables(node) -> set[str]:
    return {n.id for n in ast.walk(node) if isinstance(n, ast.Name)} & set(VARIABLES)


def _value(evaluate: Evaluator) -> float:
    """The value of a part without variables."""
    try:
        value = float(evaluate(None))
    except (ZeroDivisionError, OverflowError):
        value = math.nan
    if not math.isfinite(value):
        raise FormulaError("has a constant part without a finite value")
    return value


def _describe(node) -> str:
    match node:
        case ast.Call(func=ast.Name(id=name)):
            return f"the function {name[:40]!r}"
        case ast.Call():
            return "a call"
        case ast.Name(id=name):
            return f"the name {name[:40]!r}"
        case ast.Attribute():
            return "an attribute (a dot after a name)"
        case ast.BinOp(op=ast.BitXor()):
            return "^ (write ** for a power)"
        case ast.Constant(value=value):
            return f"the value {str(value)[:40]!r}"
    return f"a construct of the kind {type(node).__name__}"


@lru_cache(maxsize=256)
def compile_formula(text: str) -> Evaluator:
    """The function of a point (x, y, z), a tuple of any number type, that `text` writes.

    Raises FormulaError, whose text completes a sentence that begins with "the formula". The text is parsed to a syntax
    tree and translated node by node; nothing of it is ever executed as Python.
    """
    if len(text) > LONGEST_FORMULA:
        raise FormulaError(f"has {len(text)} characters; {LONGEST_FORMULA} are allowed")
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # Python's parser warns of some texts on standard error
            tree = ast.parse(text.strip(), mode="eval")
    except (SyntaxError, ValueError, RecursionError, MemoryError):
        raise FormulaError(f"cannot be read; write one expression of {VOCABULARY}") from None
    evaluator = _Compiler().compile(tree.body)
    if not _variables(tree):
        raise FormulaError("does not depend on x, y or z")
    return evaluator


class Expression(Surface):
    """Any f(x, y, z) the user types, e.g. "x**4 + y**4 + z**4 - 1", with a bounding box if the solid is bounded."""

    type: Literal["expression"] = "expression"
    formula: str = Field(max_length=LONGEST_FORMULA, description=f"f(x, y, z), written with {VOCABULARY}")
    bounds: Bounds | None = Field(None, description="a promise that this box holds the whole surface; it is checked. Without "
                                                    "it, the surface is unbounded")

    title: ClassVar[str] = "Expression"
    equation: ClassVar[str] = "f(x, y, z) = 0, as typed"

    @field_validator("formula")
    @classmethod
    def _can_be_compiled(cls, text):
        try:
            compile_formula(text)
        except FormulaError as error:
            raise ValueError(f"the formula {error}") from None
        return text

    @cached_property
    def function(self):
        evaluate = compile_formula(self.formula)
        return lambda x, y, z: evaluate((x, y, z))

    @property
    def parameters(self):
        return {}

    @property
    def family(self):
        return f"expression: {self.formula}"

    @cached_property
    def degree(self):
        try:
            value = self.function(*Polynomial.along((0.5, 0.25, 0.125), (1.0, 0.75, 0.625)))
        except (NotAlgebraic, ZeroDivisionError, OverflowError):
            return None
        return value.degree if isinstance(value, Polynomial) else None

    def region(self):
        return self.bounds.corners if self.bounds else None

    def box(self):
        return self.region() if self.sign_outside else None

    @property
    def sign_outside(self):
        return outside(self, self.bounds.corners, length=len(self.formula)).sign if self.bounds else 0
