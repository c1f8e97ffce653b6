"""Functions that are made of those in functions.py: what they do on a number type follows, proofs included.

Each is written so that intervals stay narrow: an argument stands once where that is possible, and squares are squares.
A number type that has better ways with them (converters/povray writes their names) gives a method `composed`.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import wraps
from inspect import signature

from . import functions as fn
from .functions import add, mul, quotient, sub

FUNCTIONS: dict[str, tuple[Callable, int]] = {}  # with the number of their arguments


def _composed(function: Callable) -> Callable:
    @wraps(function)
    def asked(*arguments):
        for argument in arguments:
            method = getattr(argument, "composed", None)
            if method is not None:
                return method(function.__name__, arguments)
        return function(*arguments)

    FUNCTIONS[function.__name__] = asked, len(signature(function).parameters)
    return asked


@_composed
def sinh(x):
    return (fn.exp(x) - fn.exp(-x)) * 0.5


@_composed
def cosh(x):
    """1 + 2 sinh(x/2)^2, which an interval about 0 encloses without excess."""
    return fn.whole_power(fn.exp(x * 0.5) - fn.exp(x * -0.5), 2) * 0.5 + 1.0


@_composed
def tanh(x):
    return 1.0 - quotient(2.0, fn.exp(x * 2.0) + 1.0)


@_composed
def asin(x):
    return fn.atan2(x, fn.sqrt((1.0 - x) * (x + 1.0)))


@_composed
def acos(x):
    return fn.atan2(fn.sqrt((1.0 - x) * (x + 1.0)), x)


@_composed
def atan(x):
    return fn.atan2(x, 1.0)


@_composed
def sign(x):
    """-1, 0 or 1."""
    return fn.heaviside(x) - fn.heaviside(-x)


@_composed
def ceil(x):
    return -fn.floor(-x)


@_composed
def fract(x):
    return x - fn.floor(x)


@_composed
def mod(a, b):
    """a - b floor(a / b), of the sign of b: Python's and GLSL's, not C's."""
    return add(-mul(fn.floor(quotient(a, b)), b), a)


@_composed
def mix(a, b, t):
    """a where t = 0, b where t = 1, linear in t."""
    return add(mul(sub(b, a), t), a)


@_composed
def smoothstep(start, stop, x):
    """0 below `start`, 1 above `stop`, t^2 (3 - 2 t) between them."""
    t = fn.minimum(fn.maximum(quotient(sub(x, start), sub(stop, start)), 0.0), 1.0)
    return t**2 * (t * -2.0 + 3.0)


@_composed
def smin(a, b, k):
    """The polynomial smooth minimum, min(a, b) - max(k - |a - b|, 0)^2 / (4 k): two solids joined with a fillet of size k."""
    near = fn.maximum(sub(k, fn.absolute(sub(a, b))), 0.0)
    return sub(fn.minimum(a, b), quotient(fn.whole_power(near, 2), mul(k, 4.0)))


@_composed
def smax(a, b, k):
    """The same of the larger one: -smin(-a, -b, k)."""
    return -smin(-a, -b, k)
