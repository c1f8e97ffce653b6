"""The notation of formulas: Python's expressions, translated node by node into the trees of formula.py, never executed."""

from __future__ import annotations

import ast
import math
import warnings
from functools import lru_cache

from .exact_polynomial import constant_value, vanishes
from .formula import (
    FUNCTIONS,
    Call,
    Coordinate,
    FormulaError,
    Node,
    Number,
    Power,
    Product,
    RealPower,
    call,
    has_coordinates,
    negation,
    power,
    product,
    total,
)

LONGEST_FORMULA = 2000  # characters
MOST_NODES = 500
DEEPEST_NESTING = 60
LARGEST_EXPONENT = 32
LONGEST_QUOTE = 60  # characters of a formula's part in a message

VARIABLES = ("x", "y", "z")
VOCABULARY = "x y z, numbers, + - * / **, and " + " ".join(FUNCTIONS)
CHAINS = (({ast.Add: 1, ast.Sub: -1}, total), ({ast.Mult: 1, ast.Div: -1}, product))


class _Translator:
    """Turns Python's syntax tree of `text` into a formula's; anything outside the vocabulary is refused."""

    def __init__(self, text: str):
        self.text, self.nodes = text, 0

    def tree(self, node: ast.expr, depth: int = 0) -> Node:
        self.nodes += 1
        if self.nodes > MOST_NODES:
            raise FormulaError(f"has more than {MOST_NODES} operations; write it shorter")
        if depth > DEEPEST_NESTING:
            raise FormulaError(f"is nested deeper than {DEEPEST_NESTING} levels; write it flatter")
        match node:
            case ast.Constant(value=bool()):
                pass
            case ast.Constant(value=int() | float() as value):
                return Number(self._number(node, value))
            case ast.Name(id=name) if name in VARIABLES:
                return Coordinate(VARIABLES.index(name))
            case ast.Name(id="pi"):
                return Number(math.pi)
            case ast.UnaryOp(op=ast.USub(), operand=operand):
                return self._made(node, negation, self.tree(operand, depth + 1))
            case ast.UnaryOp(op=ast.UAdd(), operand=operand):
                return self.tree(operand, depth + 1)
            case ast.BinOp(op=ast.Pow(), left=left, right=right):
                base, exponent = self.tree(left, depth + 1), self.tree(right, depth + 1)
                if isinstance(exponent, Number) and exponent.value % 1 == 0 and abs(exponent.value) > LARGEST_EXPONENT:
                    raise FormulaError(f"raises to the power {exponent.value:.0f}; exponents go from -{LARGEST_EXPONENT} "
                                       f"to {LARGEST_EXPONENT}")
                return self._made(node, power, base, exponent)
            case ast.BinOp(op=op):
                for signs, make in CHAINS:
                    if type(op) in signs:
                        return self._made(node, make, self._chain(node, signs, depth))
            case ast.Call(func=ast.Name(id=name), args=arguments, keywords=[]) if name in FUNCTIONS:
                arity = FUNCTIONS[name][1]
                if len(arguments) != arity:
                    raise FormulaError(f"gives {name} {len(arguments)} argument(s); it takes {arity}")
                return self._made(node, call, name, *(self.tree(a, depth + 1) for a in arguments))
        raise FormulaError(f"uses {_describe(node)}, which a formula may not; allowed are {VOCABULARY}")

    def _chain(self, node: ast.expr, signs, depth: int) -> list[tuple[int, Node]]:
        """The terms of a + b - c, or the factors of a * b / c, which Python nests to the left."""
        parts = []
        while isinstance(node, ast.BinOp) and type(node.op) in signs:
            self.nodes += bool(parts)  # the first is counted already
            parts.append((signs[type(node.op)], node.right))
            node = node.left
        return [(sign, self.tree(part, depth + 1)) for sign, part in [(1, node), *reversed(parts)]]

    def _made(self, node: ast.expr, make, *parts) -> Node:
        """make(*parts), or why that has no value wherever x, y, z are, with the part of the text that says so."""
        try:
            tree = make(*parts)
            _require_a_value(tree)
            return tree
        except FormulaError as error:
            quote = ast.get_source_segment(self.text, node) or self.text
            if len(quote) > LONGEST_QUOTE:
                quote = quote[:LONGEST_QUOTE] + "..."
            raise FormulaError(f"{error}, in {quote!r}") from None

    def _number(self, node: ast.expr, value) -> float:
        try:
            number = float(value)
        except OverflowError:
            number = math.inf
        if not math.isfinite(number):
            raise FormulaError("contains a number too large for double precision")
        if number == 0 and isinstance(value, float):
            digits = (ast.get_source_segment(self.text, node) or "").lower().partition("e")[0]
            if any(digit in digits for digit in "123456789"):
                raise FormulaError("contains a number too small for double precision")
        return number


def _require_a_value(tree: Node) -> None:
    """Refuses a division, root, logarithm or power that has no value because one of its operands is the same everywhere,
    x - x for instance."""
    match tree:
        case Product(factors):
            divisors = [factor for sign, factor in factors if sign < 0]
        case Power(base, n) if n < 0:
            divisors = [base]
        case Call("sqrt" | "log", (operand,)) | RealPower(operand):
            value = constant_value(operand)
            if value is not None and (value < 0 or (value == 0 and isinstance(tree, Call) and tree.name == "log")):
                raise FormulaError("has no value anywhere")
            return
        case _:
            return
    if any(map(vanishes, divisors)):
        raise FormulaError("divides by zero")


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
def parse_formula(text: str) -> Node:
    """The tree of the function f(x, y, z) that `text` writes.

    Raises FormulaError, whose text completes a sentence that begins with "the formula".
    """
    if len(text) > LONGEST_FORMULA:
        raise FormulaError(f"has {len(text)} characters; {LONGEST_FORMULA} are allowed")
    text = text.strip()
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # Python's parser warns of some texts on standard error
            parsed = ast.parse(text, mode="eval")
    except (SyntaxError, ValueError, RecursionError, MemoryError):
        raise FormulaError(f"cannot be read; write one expression of {VOCABULARY}") from None
    tree = _Translator(text).tree(parsed.body)
    if not has_coordinates(tree):
        raise FormulaError("does not depend on x, y or z")
    if (value := constant_value(tree)) is not None:
        raise FormulaError(f"does not depend on x, y or z: it is {value:g} everywhere")
    return tree
