"""From the text of a formula to its tree (formula.py): Lark's tree of the notation (formula_grammar.py), translated node by
node, never executed."""

from __future__ import annotations

import math
import sys
from collections.abc import Callable
from functools import lru_cache

from lark import Token, Tree

from .exact_polynomial import constant_value, vanishes
from .formula import (
    LEAST_NORMAL,
    Call,
    Coordinate,
    FormulaError,
    Node,
    Number,
    Power,
    Product,
    RealPower,
    Sum,
    call,
    children,
    children_with_signs,
    has_coordinates,
    negation,
    product,
    total,
)
from .formula_functions import CONSTANTS, WRITTEN, difference, function_named, joined, raised
from .formula_grammar import LONGEST_QUOTE, at, syntax_tree

LONGEST_FORMULA = 2000  # characters
MOST_NODES = 500  # operations written
MOST_IN_ALL = 2000  # with what helper lines stand for
DEEPEST_NESTING = 60

VOCABULARY = ("x y z, numbers, pi, e, + - * / ^ (or **), implicit products, |a|, = and < > <= >= with and, or, not, helper "
              "lines name = ..., and " + " ".join(WRITTEN))
ORDINARY = str.maketrans("⁺⁻⁰¹²³⁴⁵⁶⁷⁸⁹−–", "+-0123456789--")
CHAINS = {"sum": total, "product": product}
CONDITIONS = ("either", "both", "complement", "compared")
REVERSED = {">", ">=", "≥"}


class _Translator:
    """Turns Lark's tree of `text` into a formula's."""

    def __init__(self, text: str, values: dict[str, float]):
        self.text, self.values, self.nodes, self.expanded = text, values, 0, 0
        self.helpers: dict[str, tuple[Node, int, int]] = {}  # trees, their sizes and depths

    def formula(self, tree: Tree) -> Node:
        *definitions, last = tree.children
        for definition in definitions:
            name, value, _ = definition.children
            node = self.number(value, 0)
            self.helpers[str(name)] = node, _size(node), _depth(node)
        if _is(last, "compared") and str(last.children[1]) in ("=", "=="):
            left, _, right, *more = last.children
            if more:
                raise FormulaError(f"has {at(more[0])} a second {str(more[0])!r}; an equation has one = between two formulas")
            return self._less(last, self.number(left, 0), self.number(right, 0))
        return self.solid(last, 0)

    # --- solids ----------------------------------------------------------------------------------------------------
    def solid(self, tree, depth: int) -> Node:
        """The function that is negative where `tree` holds: a comparison, solids joined, or a formula (its own solid)."""
        if _is(tree, "group") and _is(tree.children[1], *CONDITIONS, "group"):
            return self.solid(tree.children[1], depth)
        if not _is(tree, *CONDITIONS):
            return self.number(tree, depth)
        self._count(tree, depth)
        if _is(tree, "either", "both"):
            kind, parts = tree.data, []
            while _is(tree, kind):
                tree, _, right = tree.children
                parts.append(right)
            solids = [self.solid(part, depth + 1) for part in (tree, *reversed(parts))]
            return joined("min" if kind == "either" else "max", solids)
        if _is(tree, "complement"):
            return negation(self.solid(tree.children[1], depth + 1))
        numbers = [self.number(part, depth + 1) for part in tree.children[::2]]
        solids = []
        for a, sign, b in zip(numbers, tree.children[1::2], numbers[1:]):
            if str(sign) in ("=", "==", "!=", "≠"):
                raise FormulaError(f"has {at(sign)} {str(sign)!r} within a solid, which only < and > bound; an equation stands "
                                   "alone, f = g")
            solids.append(self._less(tree, b, a) if str(sign) in REVERSED else self._less(tree, a, b))
        return joined("max", solids)

    def _less(self, tree, a: Node, b: Node) -> Node:
        """a - b, which is a itself where b is 0; of a sum a the tree that a - b has where it is typed."""
        if b == Number(0.0):
            return a
        return self._made(tree, negation, b) if a == Number(0.0) else self._made(
            tree, total, [*(a.terms if isinstance(a, Sum) else ((1, a),)), (-1, b)])

    # --- numbers ---------------------------------------------------------------------------------------------------
    def _count(self, tree, depth: int) -> None:
        self.nodes += 1
        self.expanded += 1
        if self.nodes > MOST_NODES or self.expanded > MOST_IN_ALL:
            raise FormulaError(f"has more than {MOST_NODES} operations, or {MOST_IN_ALL} with its helper lines put in; "
                               "write it shorter")
        if depth > DEEPEST_NESTING:
            raise FormulaError(f"is nested deeper than {DEEPEST_NESTING} levels; write it flatter")

    def number(self, tree, depth: int) -> Node:
        if isinstance(tree, Token):
            self._count(tree, depth)
            return self._word(tree, depth)
        kind, parts = tree.data, tree.children
        if kind == "group":
            return self.number(parts[1], depth)
        if kind in CONDITIONS:
            raise FormulaError(f"has in {self._quote(tree)} a condition in the place of a number; conditions bound solids, "
                               "x^2 + y^2 < 1 and z > 0 for instance")
        if kind in ("sum", "product", "implicit"):
            return self._chain(tree, depth)
        self._count(tree, depth)
        if kind == "signed":
            operand = self.number(parts[1], depth + 1)
            return operand if str(parts[0]) == "+" else self._made(tree, negation, operand)
        if kind == "raised":
            return self._made(tree, raised, self.number(parts[0], depth + 1), self.number(parts[2], depth + 1))
        if kind == "superscript":
            return self._made(tree, raised, self.number(parts[0], depth + 1), self._exponent(parts[1]))
        if kind == "absolute":
            return self._made(tree, lambda a: call("abs", a), self.number(parts[1], depth + 1))
        return self._called(tree, depth)

    def _word(self, word: Token, depth: int) -> Node:
        name = str(word)
        if word.type == "NUMBER":
            return Number(self._value(name, word))
        if word.type == "VALUE":
            return Number(float(self.values[name] if name in self.values else CONSTANTS[name]))
        if name in self.helpers:
            node, size, levels = self.helpers[name]
            self.expanded += size - 1
            self._count(word, depth + levels)
            return node
        return Coordinate("xyz".index(name.lower()))

    def _chain(self, tree: Tree, depth: int) -> Node:
        """The terms of a + b - c, or the factors of a * b / c and of a b, which nest to the left."""
        kinds = ("sum",) if tree.data == "sum" else ("product", "implicit")
        whole, parts, node = tree, [], tree
        while _is(node, *kinds) or (_is(node, "group") and _is(node.children[1], *kinds)):
            if node.data == "group":
                node = node.children[1]
                continue
            self._count(node, depth)
            if node.data == "implicit":
                self._require_one_meaning(node)
                node, right = node.children
                parts.append((1, right))
            else:
                node, sign, right = node.children
                parts.append((1 if sign.type in ("PLUS", "TIMES") else -1, right))
        trees = [(sign, self.number(part, depth + 1)) for sign, part in [(1, node), *reversed(parts)]]
        if isinstance(node, Token) and isinstance(first := trees[0][1], Sum if whole.data == "sum" else Product):
            trees[:1] = children_with_signs(first)  # of a helper line, as if it were typed here
        return self._made(whole, CHAINS["sum" if whole.data == "sum" else "product"], trees)

    def _require_one_meaning(self, tree: Tree) -> None:
        """1/2 x is half of x and 9/4y^2 is 9/4 of y^2; x/2y and x^yz (but not x^y z) have two meanings: none is guessed."""
        left, right = tree.children
        is_plain = lambda part: isinstance(part, Token) and part.type in ("NUMBER", "VALUE")
        if isinstance(right, Token) and right.type == "NUMBER":
            raise FormulaError(f"has {at(right)} the number {right!s} after {self._quote(left)}; write * between factors, "
                               "^ before an exponent")
        if _is(left, "product") and left.children[1].type == "OVER" and not (
                is_plain(left.children[0]) and is_plain(left.children[2])):
            raise FormulaError(f"has in {self._quote(tree)} a quotient and an implicit product, which may mean a/(b c) or "
                               "(a/b) c; write brackets")
        if (_is(left, "raised") and isinstance(left.children[2], Token) and left.children[2].type != "NUMBER"
                and left.children[2].end_pos == _start(right)):
            raise FormulaError(f"has in {self._quote(tree)} an exponent that may end in two places; write brackets")

    def _called(self, tree: Tree, depth: int) -> Node:
        """f(a, b), f^2(a), f a and f^2 a."""
        name, rest = tree.children[0], tree.children[1:]
        exponent = None
        if rest and _is(rest[0], "exponent"):
            exponent = self._exponent(rest[0].children[-1])
            negative = exponent.value < 0 or len(rest[0].children) == 3
            rest = rest[1:]
            if negative:
                raise FormulaError(f"has {at(name)} {name} with a negative exponent; write a{name} for the inverse function, "
                                   f"1/{name}(...) for the reciprocal")
        if tree.data == "bare":
            arguments = [self._argument(name, rest[0], depth)]
        else:
            arguments = [self.number(part, depth + 1) for part in rest if not (
                isinstance(part, Token) and part.type in ("OPEN", "CLOSE", "COMMA"))]
        make, least, most = WRITTEN[function_named(str(name))]
        if not least <= len(arguments) <= most:
            takes = str(least) if least == most else f"{least} or more" if most > least + 1 else f"{least} or {most}"
            raise FormulaError(f"gives {at(name)} {name} {len(arguments)} argument(s); it takes {takes}")
        value = self._made(tree, make, *arguments)
        return value if exponent is None else self._made(tree, raised, value, exponent)

    def _argument(self, name: Token, tree: Tree, depth: int) -> Node:
        """Of sin 2 pi x: numbers, then one more factor; sin x y has two meanings."""
        *coefficients, _ = tree.children
        if not all(isinstance(part, Token) and part.type in ("NUMBER", "VALUE") for part in coefficients):
            raise FormulaError(f"has {at(name)} {name} with several factors, {self._quote(tree)}, after it; write its argument "
                               "in brackets")
        trees = [(1, self.number(part, depth + 1)) for part in tree.children]
        return trees[0][1] if len(trees) == 1 else self._made(tree, product, trees)

    def _exponent(self, word: Token) -> Number:
        return Number(float(str(word).translate(ORDINARY)))

    def _made(self, tree, make: Callable, *parts) -> Node:
        """make(*parts), or why that has no value wherever x, y, z are, with the part of the text that says so."""
        try:
            made = make(*parts)
            _require_a_value(made)
            return made
        except FormulaError as error:
            raise FormulaError(f"{error}, in {self._quote(tree)}") from None

    def _quote(self, tree) -> str:
        start, stop = _start(tree), tree.end_pos if isinstance(tree, Token) else tree.meta.end_pos
        line = tree.line if isinstance(tree, Token) else tree.meta.line
        column = tree.column if isinstance(tree, Token) else tree.meta.column
        quote = " ".join(self.text[start:stop].split())
        quote = quote if len(quote) <= LONGEST_QUOTE else quote[:LONGEST_QUOTE] + "..."
        return f"{quote!r} (line {line}, column {column})"

    def _value(self, text: str, word: Token) -> float:
        digits = text.replace("_", "").lower()
        try:
            number = float(int(digits, 16) if digits.startswith("0x") else float(digits))
        except (OverflowError, ValueError):
            number = math.inf
        if not math.isfinite(number):
            raise FormulaError(f"contains {at(word)} a number too large for double precision")
        is_zero = number == 0 and (digits.startswith("0x") or not any(d in digits.partition("e")[0] for d in "123456789"))
        if number < LEAST_NORMAL and not is_zero:
            raise FormulaError(f"contains {at(word)} a number too small for double precision")
        return number


def _is(tree, *kinds: str) -> bool:
    return isinstance(tree, Tree) and tree.data in kinds


def _start(tree) -> int:
    return tree.start_pos if isinstance(tree, Token) else tree.meta.start_pos


def _size(node: Node) -> int:
    return 1 + sum(map(_size, children(node)))


def _depth(node: Node) -> int:
    return 1 + max(map(_depth, children(node)), default=0)


def _require_a_value(tree: Node) -> None:
    """Refuses a division, root, logarithm or power that has no value because one of its operands is the same everywhere,
    x - x for instance."""
    match tree:
        case Product(factors):
            divisors = [factor for sign, factor in factors if sign < 0]
        case Power(base, n) if n < 0:
            divisors = [base]
        case Call("mod", (_, divisor)) | Call("smin" | "smax", (_, _, divisor)):
            divisors = [divisor]
        case Call("smoothstep", (start, stop, _)):
            divisors = [difference(stop, start)]
        case Call("sqrt" | "log", (operand,)) | RealPower(operand):
            value = constant_value(operand)
            if value is not None and (value < 0 or (value == 0 and isinstance(tree, Call) and tree.name == "log")):
                raise FormulaError("has no value anywhere")
            return
        case _:
            return
    if any(map(vanishes, divisors)):
        raise FormulaError("divides by zero")


@lru_cache(maxsize=1024)
def parse_formula(text: str, values: tuple[tuple[str, float], ...] = ()) -> Node:
    """The tree of the function f(x, y, z) that `text` writes; `values` are those of its named parameters.

    Raises FormulaError, whose text completes a sentence that begins with "the formula".
    """
    if len(text) > LONGEST_FORMULA:
        raise FormulaError(f"has {len(text)} characters; {LONGEST_FORMULA} are allowed")
    tree = _Translator(text, dict(values)).formula(syntax_tree(text, dict(values)))
    if not has_coordinates(tree):
        raise FormulaError("does not depend on x, y or z")
    if (value := constant_value(tree)) is not None:
        number = f"{float(value):g}" if abs(value) <= sys.float_info.max else "no finite number"
        raise FormulaError(f"does not depend on x, y or z: it is {number} everywhere")
    return tree
