"""Formulas as trees: what a user's f(x, y, z) is, whatever notation it was typed in.

A tree is made by the functions in small letters (`total`, `product`, `power`, `call`), which fold its constant parts once,
in IEEE arithmetic, and refuse those without a finite value; the classes are what they return. `evaluator` turns a tree into
a function of a point of any number type. `parametrised` takes a tree's numbers out, so that formulas which differ in numbers
alone are one function with parameters. Sums and products are chains of any length, evaluated from left to right: their
length is no depth.
"""

from __future__ import annotations

import math
import sys
from collections import Counter
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from types import MappingProxyType

from ..numbers import composed
from ..numbers import functions as fn

FUNCTIONS: dict[str, tuple[Callable, int]] = {
    "sqrt": (fn.sqrt, 1), "cbrt": (fn.cbrt, 1), "sin": (fn.sin, 1), "cos": (fn.cos, 1), "tan": (fn.tan, 1),
    "exp": (fn.exp, 1), "log": (fn.log, 1), "abs": (fn.absolute, 1), "min": (fn.minimum, 2), "max": (fn.maximum, 2),
    "floor": (fn.floor, 1), "heaviside": (fn.heaviside, 1), "atan2": (fn.atan2, 2), **composed.FUNCTIONS}


JUMPING = {"floor", "ceil", "heaviside", "sign", "fract", "mod"}
LEAST_NORMAL = sys.float_info.min  # Dr.Jit's threads take smaller numbers for zero, the thread that calls them does not


class FormulaError(ValueError):
    """A formula that is not one; the text completes a sentence that begins with "the formula"."""


@dataclass(frozen=True, slots=True)
class Number:
    value: float


@dataclass(frozen=True, slots=True)
class Parameter:
    """A number that is given when the tree is evaluated."""

    name: str


@dataclass(frozen=True, slots=True)
class Coordinate:
    axis: int  # 0, 1, 2 for x, y, z


@dataclass(frozen=True, slots=True)
class Negation:
    operand: Node


@dataclass(frozen=True, slots=True)
class Sum:
    """The first term, then + or - (+1, -1) each of the others; the first sign is +1."""

    terms: tuple[tuple[int, Node], ...]


@dataclass(frozen=True, slots=True)
class Product:
    """The first factor, then * or / (+1, -1) each of the others; the first sign is +1."""

    factors: tuple[tuple[int, Node], ...]


@dataclass(frozen=True, slots=True)
class Power:
    """A whole exponent, which is part of the tree's structure."""

    base: Node
    exponent: int


@dataclass(frozen=True, slots=True)
class RealPower:
    """An exponent that is no whole number, or a function of the coordinates (numbers.functions.power)."""

    base: Node
    exponent: Node


@dataclass(frozen=True, slots=True)
class Call:
    """A function of FUNCTIONS."""

    name: str
    arguments: tuple[Node, ...]


Node = Number | Parameter | Coordinate | Negation | Sum | Product | Power | RealPower | Call


def children(tree: Node) -> tuple[Node, ...]:
    match tree:
        case Negation(operand):
            return (operand,)
        case Sum(parts) | Product(parts):
            return tuple(part for _, part in parts)
        case Power(base):
            return (base,)
        case RealPower(base, exponent):
            return base, exponent
        case Call(_, arguments):
            return arguments
    return ()


def children_with_signs(chain: Sum | Product) -> tuple[tuple[int, Node], ...]:
    return chain.terms if isinstance(chain, Sum) else chain.factors


# --- making trees ------------------------------------------------------------------------------------------------------
def _folded(tree: Node) -> Node:
    """`tree`, or its value where all its children are numbers."""
    if not all(isinstance(child, Number) for child in children(tree)):
        return tree
    try:
        value = float(evaluator(tree)(()))
    except (ArithmeticError, ValueError, TypeError):  # TypeError: a power that is a complex number
        value = math.nan
    if not math.isfinite(value):
        raise FormulaError("has a constant part without a finite value")
    if 0 < abs(value) < LEAST_NORMAL:
        raise FormulaError("has a constant part too small for double precision")
    return Number(value)


def negation(operand: Node) -> Node:
    return _folded(Negation(operand))


def total(terms: Iterable[tuple[int, Node]]) -> Node:
    """Sum of (sign, term); the first sign must be +1."""
    return _chain(Sum, terms)


def product(factors: Iterable[tuple[int, Node]]) -> Node:
    """Product of (sign of the exponent, factor); the first sign must be +1."""
    factors = tuple(factors)
    if any(sign < 0 and factor == Number(0.0) for sign, factor in factors):
        raise FormulaError("divides by zero")
    return _chain(Product, factors)


def _chain(kind, parts) -> Node:
    """Numbers at the beginning of a chain are folded: arithmetic goes from left to right."""
    parts = tuple(parts)
    while len(parts) > 1 and isinstance(parts[0][1], Number) and isinstance(parts[1][1], Number):
        parts = ((1, _folded(kind(parts[:2]))), *parts[2:])
    return kind(parts) if len(parts) > 1 else parts[0][1]


def power(base: Node, exponent: Node) -> Node:
    if isinstance(exponent, Number) and exponent.value == int(exponent.value):
        n = int(exponent.value)
        if n < 0 and base == Number(0.0):
            raise FormulaError("divides by zero")
        return _folded(Power(base, n))
    if isinstance(base, Number) and base.value < 0:
        raise FormulaError(f"raises the negative number {base.value:g} to a power that is no whole number")
    return _folded(RealPower(base, exponent))


def call(name: str, *arguments: Node) -> Node:
    return _folded(Call(name, arguments))


# --- evaluating them ---------------------------------------------------------------------------------------------------
def evaluator(tree: Node) -> Callable:
    """The function (point, numbers) -> value: `point` holds x, y, z, of any number type, `numbers` the parameters.

    Equal parts are evaluated once. Of x*x an interval then knows that both factors are one number.
    """
    steps: list[tuple[Callable, tuple[int, ...]]] = []
    place: dict[Node, int] = {}

    def visit(node: Node) -> int:
        if node not in place:
            operands = tuple(map(visit, children(node)))
            place[node] = len(steps)
            steps.append((_operation(node), operands))
            if isinstance(node, Product | Negation):
                parts = tuple(map(visit, sign_parts(node)))
                steps.append((lambda point, numbers, *values: fn.of_sign(*values), (place[node], *parts)))
                place[node] = len(steps) - 1
        return place[node]

    visit(tree)

    def evaluate(point, numbers=MappingProxyType({})):
        values: list = []
        for apply, operands in steps:
            values.append(apply(point, numbers, *(values[k] for k in operands)))
        return values[-1]

    return evaluate


def _operation(node: Node) -> Callable:
    """What `node` does: a function of (point, numbers, *values of its children)."""
    match node:
        case Number(value):
            return lambda point, numbers: value
        case Parameter(name):
            return lambda point, numbers: numbers[name]
        case Coordinate(axis):
            return lambda point, numbers: point[axis]
        case Negation():
            return lambda point, numbers, a: -a
        case Sum(terms):
            return _from_left([fn.add if sign > 0 else fn.sub for sign, _ in terms[1:]])
        case Product(factors):
            return _from_left([fn.mul if sign > 0 else fn.quotient for sign, _ in factors[1:]])
        case Power(_, n):
            return lambda point, numbers, a: fn.whole_power(a, n)
        case RealPower():
            return lambda point, numbers, a, b: fn.power(a, b)
        case Call(name):
            function = FUNCTIONS[name][0]
            return lambda point, numbers, *arguments: function(*arguments)


def _from_left(operations: list[Callable]) -> Callable:
    def apply(point, numbers, value, *others):
        for operation, other in zip(operations, others):
            value = operation(value, other)
        return value
    return apply


# --- structure ---------------------------------------------------------------------------------------------------------
def parametrised(tree: Node, start: int = 0) -> tuple[Node, dict[str, float]]:
    """`tree` with its numbers as parameters c<start>, c<start + 1>, ..., and their values.

    Whole exponents are structure, and so are the numbers of a real power, of which number types need to know the sign.
    Equal parts stay equal: an interval knows of (x - 1)*(x - 1) that it is a square.
    """
    values: dict[str, float] = {}
    made: dict[Node, Node] = {}

    def visit(node: Node) -> Node:
        if not isinstance(node, Number):
            if node not in made:
                made[node] = parts_of(node)
            return made[node]
        name = f"c{start + len(values)}"
        values[name] = node.value
        return Parameter(name)

    def parts_of(node: Node) -> Node:
        match node:
            case RealPower(base, exponent):
                return RealPower(*(part if isinstance(part, Number) else visit(part) for part in (base, exponent)))
        return rebuilt(node, visit)

    return visit(tree), values


def rebuilt(node: Node, change: Callable[[Node], Node]) -> Node:
    """`node` with `change` of every child in the child's place."""
    match node:
        case Negation(operand):
            return Negation(change(operand))
        case Sum(parts) | Product(parts):
            return type(node)(tuple((sign, change(part)) for sign, part in parts))
        case Power(base, n):
            return Power(change(base), n)
        case RealPower(base, exponent):
            return RealPower(change(base), change(exponent))
        case Call(name, arguments):
            return Call(name, tuple(map(change, arguments)))
    return node


def written(tree: Node) -> str:
    """The tree in the notation of formulas, every operation in brackets: equal texts are equal trees."""
    match tree:
        case Number(value):
            return repr(value)
        case Parameter(name):
            return name
        case Coordinate(axis):
            return "xyz"[axis]
        case Negation(operand):
            return f"(-{written(operand)})"
        case Sum(((_, first), *rest)):
            return f"({written(first)}{''.join('-+'[sign > 0] + written(part) for sign, part in rest)})"
        case Product(((_, first), *rest)):
            return f"({written(first)}{''.join('/*'[sign > 0] + written(part) for sign, part in rest)})"
        case Power(base, n):
            return f"{written(base)}**{n}" if n >= 0 else f"{written(base)}**({n})"
        case RealPower(base, exponent):
            return f"({written(base)}**{written(exponent)})"
        case Call(name, arguments):
            return f"{name}({', '.join(map(written, arguments))})"


def has_coordinates(tree: Node) -> bool:
    return isinstance(tree, Coordinate) or any(map(has_coordinates, children(tree)))


def has_jumps(tree: Node) -> bool:
    return (isinstance(tree, Call) and tree.name in JUMPING) or any(map(has_jumps, children(tree)))


def sign_parts(tree: Node) -> tuple[Node, ...]:
    """Parts of `tree` whose signs multiply to its own, where it is defined; none where it is not negative by its structure.

    A part that occurs twice is a square, which does not count: x*y*x*y has none.
    """
    def of(node: Node) -> tuple[Node, ...]:
        match node:
            case Number(value):
                return () if value >= 0 else (Number(-1.0),)
            case Negation(operand):
                return Number(-1.0), *of(operand)
            case Product(factors):
                return tuple(part for _, factor in factors for part in of(factor))
            case Power(base, n):
                return of(base) if n % 2 else ()
            case Call("cbrt", (operand,)):
                return of(operand)
            case RealPower() | Call("sqrt" | "exp" | "abs"):
                return ()
        return (node,)

    return tuple(part for part, times in Counter(of(tree)).items() if times % 2)


def degree(tree: Node) -> int | None:
    """The degree of the polynomial that `tree` is by its structure, whatever its numbers; None where it is none."""
    match tree:
        case Number() | Parameter():
            return 0
        case Coordinate():
            return 1
        case Negation(operand):
            return degree(operand)
        case Sum(terms):
            degrees = [degree(term) for _, term in terms]
            return None if None in degrees else max(degrees)
        case Product(factors):
            if any(sign < 0 and not isinstance(factor, (Number, Parameter)) for sign, factor in factors):
                return None
            degrees = [degree(factor) for _, factor in factors]
            return None if None in degrees else sum(degrees)
        case Power(base, n) if n >= 0:
            of_base = degree(base)
            return None if of_base is None else n * of_base
    return None
