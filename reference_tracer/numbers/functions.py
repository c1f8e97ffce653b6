"""Elementary functions that accept every number type a surface is evaluated on.

A surface is written once, as f(x, y, z). Whether x, y, z are floats, NumPy or Dr.Jit arrays, dual numbers, intervals
or polynomials is decided by the caller: these functions ask the argument for a method of their own name first, and
fall back to the library of the argument's array type.
"""

import math
import operator
from fractions import Fraction

import drjit as dr
import numpy as np

__all__ = ["sqrt", "cbrt", "sin", "cos", "tan", "exp", "log", "absolute", "floor", "heaviside", "atan2", "power", "minimum",
           "maximum", "select", "fma", "where_larger", "add", "sub", "mul", "quotient", "whole_power", "of_sign", "flat_slope"]

# Dr.Jit's fp64 sine and cosine are good to an absolute 2**-52 below this angle, and from about 2**31.6 on they return
# numbers of any size: `make enclosures`. Beyond it Dr.Jit's floats have none here, NaN, and
# intervals answer [-1, 1] and the whole line.
LARGEST_ANGLE = 2.0**30

_PLAIN = (int, float, np.ndarray, np.generic)
LARGEST_SHORT_EXPONENT = 64  # above it, roots and products cost more than exp and log


def _wave_of_array(function):
    """NaN, which decides nothing (M7), where Dr.Jit's result means nothing."""
    return lambda x: dr.select(dr.abs(x) <= LARGEST_ANGLE, function(x), math.nan)


def _exp_of_array(x):
    """drjit.exp makes a whole number of its argument, and what LLVM makes of a NaN is anything: where it sees one come (in
    `0**x`, log(0) x) whole kernels may compute anything, or never end. Asked first, it is a NaN."""
    return dr.select(x == x, dr.exp(x), math.nan)


# drjit.tan loses digits below |x| = 1e-4 (relative error 3e-9 in 1.5); the quotient is good to 3 ulp there
_ON_DRJIT = {"sqrt": dr.sqrt, "cbrt": dr.cbrt, "sin": _wave_of_array(dr.sin), "cos": _wave_of_array(dr.cos),
             "tan": _wave_of_array(lambda x: dr.sin(x) / dr.cos(x)), "exp": _exp_of_array, "log": dr.log, "absolute": dr.abs,
              "floor": dr.floor, "heaviside": lambda x: dr.select(x >= 0, type(x)(1), dr.select(x < 0, type(x)(0), x))}


def _elementary(name: str, on_scalar, on_numpy=None):
    on_drjit, on_numpy = _ON_DRJIT[name], on_numpy or getattr(np, name)

    def function(x):
        if dr.is_array_v(x):
            return on_drjit(x)
        method = getattr(x, name, None)
        if method is not None:
            return method()
        if isinstance(x, (float, int)):
            try:
                return on_scalar(x)
            except (ValueError, OverflowError):  # outside the domain or the range: as IEEE arithmetic says it
                with np.errstate(all="ignore"):
                    return float(on_numpy(np.float64(x)))
        with np.errstate(all="ignore"):
            return on_numpy(x)

    function.__name__ = name
    function.__doc__ = f"{name}(x) for any number type."
    return function


sqrt = _elementary("sqrt", math.sqrt)
cbrt = _elementary("cbrt", math.cbrt)
sin = _elementary("sin", math.sin)
cos = _elementary("cos", math.cos)
tan = _elementary("tan", math.tan)
exp = _elementary("exp", math.exp)
log = _elementary("log", lambda x: math.log(x) if x else -math.inf)
absolute = _elementary("absolute", abs)
floor = _elementary("floor", lambda x: float(math.floor(x)))
heaviside = _elementary("heaviside", lambda x: 0.0 if x < 0 else 1.0 if x >= 0 else x, lambda x: np.heaviside(x, 1.0))


def flat_slope(function, x):
    """The slope at x of a function that is constant between jumps: 0, and NaN, which bounds nothing, where x is an interval
    with a jump in it."""
    method = getattr(x, "flat_slope", None)
    return 0.0 * function(x) if method is None else method(function)


def atan2(y, x):
    """The angle of (x, y) in (-pi, pi], 0 at the origin, for any number types; it jumps where y = 0 and x < 0."""
    for number, name in ((y, "atan2"), (x, "atan2_of")):
        method = getattr(number, name, None)
        if method is not None:
            return method(x if number is y else y)
    if dr.is_array_v(y) or dr.is_array_v(x):
        return dr.select((y == y) & (x == x), dr.atan2(y, x), math.nan)  # Dr.Jit has 0 there
    value = np.arctan2(np.add(y, 0.0), np.add(x, 0.0))  # the sign of a zero says nothing
    return float(value) if np.ndim(value) == 0 else value


def _arithmetic(name: str, operation):
    def function(a, b):
        reflected = getattr(b, f"__r{name}__", None)
        # an array of Dr.Jit cannot stand on the left of a number type of ours
        swapped = reflected and dr.is_array_v(a) and not dr.is_array_v(b) and not isinstance(b, (int, float))
        return reflected(a) if swapped else operation(a, b)

    function.__name__ = name
    return function


add, sub, mul = (_arithmetic(name, getattr(operator, name)) for name in ("add", "sub", "mul"))


def quotient(a, b):
    """a / b as IEEE arithmetic has it, for Python's floats too."""
    if not (isinstance(a, _PLAIN) and isinstance(b, _PLAIN)):
        # an array of Dr.Jit cannot stand on the left of a number type of ours
        return b.__rtruediv__(a) if dr.is_array_v(a) and not (dr.is_array_v(b) or isinstance(b, _PLAIN)) else a / b
    with np.errstate(all="ignore"):
        value = np.true_divide(a, b)
    return float(value) if isinstance(a, (int, float)) and isinstance(b, (int, float)) else value


def whole_power(base, n: int):
    """base**n for an int n, as IEEE arithmetic has it, for Python's floats too."""
    if not isinstance(base, _PLAIN):
        return base**n
    with np.errstate(all="ignore"):
        return float(np.float64(base)**n) if isinstance(base, (int, float)) else base**n


def of_sign(number, *parts):
    """`number`, whose sign is that of the product of `parts`: types that hold many numbers at once may learn from it that
    none of them is negative, as of x*y*x*y, which has no such parts."""
    method = getattr(number, "of_sign", None)
    return number if method is None else method(*parts)


def power(base, exponent):
    """base ** exponent for a real `exponent`, for any number types; not for whole exponents, which `**` takes.

    Defined for base >= 0 (NaN below): 0 for base 0 and exponent > 0, infinite for exponent < 0.
    """
    method = getattr(base, "power", None)
    if method is not None:
        return method(exponent)
    method = getattr(exponent, "power_of", None)
    if method is not None:
        return method(base)
    if dr.is_array_v(base) or dr.is_array_v(exponent):
        return _power_on_drjit(base, exponent)
    with np.errstate(all="ignore"):
        value = np.where(np.less(base, 0), math.nan, np.power(np.abs(base), np.float64(exponent)))
    return float(value) if value.ndim == 0 else value


def eighths(exponent) -> tuple[int, int] | None:
    """(n, k) with |exponent| = n + k/8 for a Python number of that form: its powers need square roots and products only."""
    if not isinstance(exponent, (int, float)) or not abs(exponent) <= LARGEST_SHORT_EXPONENT:
        return None
    n, rest = divmod(8 * abs(exponent), 8)
    return (int(n), int(rest)) if rest == int(rest) else None


def _power_on_drjit(base, exponent):
    # drjit.power is exp2(log2(base) exponent), whose relative error grows with |log2 of the result|, as does the last line's
    if (short := eighths(exponent)) is not None:
        n, k = short
        root = dr.abs(base)  # -0.0 is no negative number
        value = root**n if n else 1.0
        for bit in (4, 2, 1):
            root = dr.sqrt(root)
            value = value * root if k & bit else value
        value = 1.0 / value if exponent < 0 else value
        return dr.select(base >= 0, value, math.nan)
    value = _exp_of_array(dr.log(base) * exponent)
    return value if isinstance(exponent, (int, float)) else dr.select((exponent == 0) & (base >= 0), 1.0, value)


def less_one(exponent, base):
    """exponent - 1, as an interval where `base` is one and floats cannot hold the difference."""
    exact = isinstance(exponent, (int, float)) and Fraction(exponent) - 1 == exponent - 1.0
    return exponent - 1.0 if exact or not hasattr(base, "of") else base.of(exponent) - 1.0


def times_log(power, base):
    """power log(base) for power = base ** exponent: the slope in the exponent, 0 where the power vanishes."""
    slope = power * log(base)
    return slope if hasattr(slope, "of") else select(power == 0, power, slope)


def select(condition, if_true, if_false):
    """Element by element: `if_true` where `condition` holds, else `if_false`."""
    if any(dr.is_array_v(v) for v in (condition, if_true, if_false)):
        return dr.select(condition, if_true, if_false)
    if isinstance(condition, (bool, np.bool_)):
        return if_true if condition else if_false
    return np.where(condition, if_true, if_false)


def fma(a, b, c):
    """a b + c for any number types; rounded once where all three are floats and arrays of Dr.Jit."""
    fused = all(dr.is_array_v(v) or isinstance(v, (int, float)) for v in (a, b, c)) and any(map(dr.is_array_v, (a, b, c)))
    return dr.fma(a, b, c) if fused else a * b + c


def _extremum(name: str, on_drjit, on_numpy):
    def function(a, b):
        for first, second in ((a, b), (b, a)):  # both are symmetric in their arguments
            method = getattr(first, name, None)
            if method is not None:
                return method(second)
        if dr.is_array_v(a) or dr.is_array_v(b):
            return on_drjit(a, b)
        value = on_numpy(a, b)
        return float(value) if np.ndim(value) == 0 else value

    function.__name__ = name
    function.__doc__ = f"{name}(a, b) for any number types."
    return function


minimum = _extremum("minimum", dr.minimum, np.minimum)
maximum = _extremum("maximum", dr.maximum, np.maximum)


def where_larger(a, b, if_a, if_b):
    """Element by element: `if_a` where a >= b, else `if_b`; for intervals that overlap, the hull of both."""
    for number in (a, b):
        method = getattr(number, "where_larger", None)
        if method is not None:
            return method(a, b, if_a, if_b)
    if dr.is_array_v(a) or dr.is_array_v(b):  # of two Python numbers dr.select makes one of single precision
        if_a, if_b = map(dr.expr_t(a, b), (if_a, if_b))
    return select(a >= b, if_a, if_b)
