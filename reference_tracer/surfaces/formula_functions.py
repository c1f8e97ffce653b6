"""The names of functions and constants in formulas, and the trees that they stand for.

What formula.FUNCTIONS has is called under its own name; every other function is written with those, so that all that is
known of them (enclosures, derivatives, signs, text for other programs) is known of it.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

from .formula import FUNCTIONS, FormulaError, Node, Number, call, power, product, total

LARGEST_EXPONENT = 32
ANY = 64  # arguments of a function that takes any number of them

CONSTANTS = {"pi": math.pi, "π": math.pi, "PI": math.pi, "Pi": math.pi, "e": math.e, "tau": math.tau, "τ": math.tau}


def raised(base: Node, exponent: Node) -> Node:
    if isinstance(exponent, Number) and exponent.value % 1 == 0 and abs(exponent.value) > LARGEST_EXPONENT:
        raise FormulaError(f"raises to the power {exponent.value:.0f}; exponents go from -{LARGEST_EXPONENT} "
                           f"to {LARGEST_EXPONENT}")
    return power(base, exponent)


def joined(name: str, arguments: Sequence[Node]) -> Node:
    """The minimum or maximum of any number of trees, nested no deeper than it takes."""
    if len(arguments) == 1:
        return arguments[0]
    half = (len(arguments) + 1) // 2
    return call(name, joined(name, arguments[:half]), joined(name, arguments[half:]))


def over(a: Node, b: Node) -> Node:
    return product([(1, a), (-1, b)])


def difference(a: Node, b: Node) -> Node:
    return total([(1, a), (-1, b)])


def _length(*arguments: Node) -> Node:
    return call("sqrt", total([(1, power(a, Number(2.0))) for a in arguments]))


def _times(number: float) -> Callable[[Node], Node]:
    return lambda a: product([(1, a), (1, Number(number))])


ONE = Number(1.0)

# the tree of a call, and the least and the largest number of its arguments
WRITTEN: dict[str, tuple[Callable[..., Node], int, int]] = {
    **{name: (lambda *a, name=name: call(name, *a), arity, arity) for name, (_, arity) in FUNCTIONS.items()},
    "min": (lambda *a: joined("min", a), 2, ANY), "max": (lambda *a: joined("max", a), 2, ANY),
    "pow": (raised, 2, 2), "sqr": (lambda a: power(a, Number(2.0)), 1, 1),
    "hypot": (_length, 2, ANY), "length": (_length, 1, ANY),
    "atan": (lambda *a: call("atan", *a) if len(a) == 1 else call("atan2", *a), 1, 2),
    "step": (lambda edge, a: call("heaviside", difference(a, edge)), 2, 2),
    "clamp": (lambda a, low, high: call("min", call("max", a, low), high), 3, 3),
    "round": (lambda a: call("floor", total([(1, a), (1, Number(0.5))])), 1, 1),
    "log10": (lambda a: over(call("log", a), Number(math.log(10))), 1, 1),
    "log2": (lambda a: over(call("log", a), Number(math.log(2))), 1, 1),
    "cot": (lambda a: over(ONE, call("tan", a)), 1, 1), "sec": (lambda a: over(ONE, call("cos", a)), 1, 1),
    "csc": (lambda a: over(ONE, call("sin", a)), 1, 1), "inversesqrt": (lambda a: over(ONE, call("sqrt", a)), 1, 1),
    "radians": (_times(math.pi / 180), 1, 1), "degrees": (_times(180 / math.pi), 1, 1)}

# other names for them, and names from elsewhere that mean something else here or nothing
ALIASES = {"ln": "log", "arcsin": "asin", "arccos": "acos", "arctan": "atan", "arctan2": "atan2", "sgn": "sign", "fabs": "abs",
           "lerp": "mix", "ceiling": "ceil", "frac": "fract", "√": "sqrt"}
FOREIGN = {
    "sen": "sin", "seno": "sin", "tg": "tan", "ctg": "cot", "cotan": "cot", "arctg": "atan", "sh": "sinh", "ch": "cosh",
    "th": "tanh", "lg": "log10", "int": "floor", "trunc": "floor", "fmod": "mod", "root": "sqrt", "norm": "length",
    "magnitude": "length", "heavisidetheta": "heaviside", "smoothmin": "smin", "opsmoothunion": "smin"}


def function_named(name: str) -> str | None:
    """The name in WRITTEN of the function that is written `name`; capitals do not count."""
    name = ALIASES.get(name.lower(), name.lower())
    return name if name in WRITTEN else None
