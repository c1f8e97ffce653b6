"""Elementary functions that accept every number type a surface is evaluated on.

A surface is written once, as f(x, y, z). Whether x, y, z are floats, NumPy or Dr.Jit arrays, dual numbers, intervals
or polynomials is decided by the caller: these functions ask the argument for a method of their own name first, and
fall back to the library of the argument's array type.
"""

import math

import drjit as dr
import numpy as np

__all__ = ["sqrt", "cbrt", "sin", "cos", "tan", "exp", "log", "absolute", "minimum", "maximum", "select", "fma",
           "where_larger"]


def _tan_of_array(x):
    # drjit.tan loses digits below |x| = 1e-4 (relative error 3e-9 in 1.5); the quotient is good to 3 ulp everywhere.
    return dr.sin(x) / dr.cos(x)


_ON_DRJIT = {"sqrt": dr.sqrt, "cbrt": dr.cbrt, "sin": dr.sin, "cos": dr.cos, "tan": _tan_of_array,
             "exp": dr.exp, "log": dr.log, "absolute": dr.abs}


def _elementary(name: str, on_scalar):
    on_drjit, on_numpy = _ON_DRJIT[name], getattr(np, name)

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
