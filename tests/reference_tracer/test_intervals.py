"""Interval arithmetic: every enclosure holds every value, checked in exact and in 50-digit arithmetic."""

import math
from decimal import Decimal, localcontext
from fractions import Fraction

import numpy as np
import pytest

from raytruth.reference_tracer.backend import backend
from raytruth.reference_tracer.numbers import Dual, Interval, OutwardInterval
from raytruth.reference_tracer.numbers import functions as fn
from raytruth.reference_tracer.surfaces.expression import forms_of

COUNT, SAMPLES = 60, 5
KINDS = ("float", "numpy", "drjit")


def _bounds(seed: int, positive=False, largest=2.0) -> tuple[np.ndarray, np.ndarray]:
    """Random intervals of either sign, thin and wide, with and without zero, 1e-4 to 10**largest in size."""
    random = np.random.default_rng(seed)
    a, b = (np.where(random.random(COUNT) < 0.5, -1, 1) * 10.0**random.uniform(-4, largest, COUNT) for _ in range(2))
    b[::4] = a[::4] * (1 + 1e-15)
    b[::7] = a[::7]
    if positive:
        a, b = np.abs(a), np.abs(b)
    return np.minimum(a, b), np.maximum(a, b)


def _samples(low, high) -> np.ndarray:
    """(COUNT, SAMPLES) floats of every interval, its ends among them."""
    inner = low + (high - low) * np.random.default_rng(1).random((SAMPLES - 2, len(low)))
    return np.stack([low, high, *np.clip(inner, low, high)], axis=-1)


def enclose(phi, number, kind: str, *bounds):
    """phi of the intervals `bounds`, as NumPy (low, high)."""
    if kind == "float":
        results = [phi(*(number(float(low[i]), float(high[i])) for low, high in bounds)) for i in range(COUNT)]
        return np.array([r.low for r in results]), np.array([r.high for r in results])
    array = {"numpy": np.asarray, "drjit": backend().Float}[kind]
    result = phi(*(number(array(low), array(high)) for low, high in bounds))
    return tuple(np.broadcast_to(array(bound) if kind == "numpy" else array(bound).numpy(), COUNT)
                 for bound in (result.low, result.high))


def assert_holds(low, high, exact):
    """`exact(i, k)` is the value at sample k of interval i, a Fraction or a Decimal."""
    for i in range(COUNT):
        for k in range(SAMPLES):
            value = exact(i, k)
            number = type(value)
            assert number(float(low[i])) <= value <= number(float(high[i])), (i, k, low[i], high[i], float(value))


RING = {
    "a + b": lambda a, b: a + b, "a - b": lambda a, b: a - b, "a b": lambda a, b: a * b, "-a": lambda a, b: -a,
    "a + 1": lambda a, b: a + 1, "1 - a": lambda a, b: 1 - a, "3 a": lambda a, b: 3 * a, "a * -3": lambda a, b: a * -3,
    "a / 3": lambda a, b: a / 3, "a / -3": lambda a, b: a / -3, "a / b": lambda a, b: a / b,
    "3 / b": lambda a, b: 3 / b,
    "a a": lambda a, b: a * a, "a^0": lambda a, b: a**0 + b**0, "a^1": lambda a, b: a**1, "a^2": lambda a, b: a**2,
    "a^3": lambda a, b: a**3, "a^4": lambda a, b: a**4, "a^7": lambda a, b: a**7, "b^-2": lambda a, b: b**-2,
    "b^-3": lambda a, b: b**-3, "mixed": lambda a, b: (a * b - a**2) / (1 + b**2)}


def _ring_check(name, number, kind):
    a, b = _bounds(2), _bounds(3, positive="/ b" in name or "b^-" in name)
    xs, ys = _samples(*a), _samples(*b)
    low, high = enclose(RING[name], number, kind, a, b)
    assert_holds(low, high, lambda i, k: RING[name](Fraction(xs[i, k]), Fraction(ys[i, k])))


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("name", RING)
def test_outward_rounded_arithmetic_holds_the_exact_result(name, kind):
    """Floats are rationals: Fraction computes the true value of every operation on the samples."""
    _ring_check(name, OutwardInterval, kind)


@pytest.mark.parametrize("name", ["a + b", "a b", "a / b", "a^7", "mixed"])
def test_rounding_to_nearest_is_not_a_proof(name):
    """The same check refutes `Interval`, whose bounds may fall on the wrong side of the exact value."""
    with pytest.raises(AssertionError):
        _ring_check(name, Interval, "numpy")


def _decimal_sin(x: Decimal, quarter_turns: int = 0) -> Decimal:
    """sin(x + quarter_turns pi/2) by its series."""
    start = quarter_turns % 2  # the cosine's series begins with 1, the sine's with x
    term, n, total = x if start == 0 else Decimal(1), 1 - start, Decimal(0)
    while abs(term) > Decimal("1e-60"):
        total += term
        term *= -x * x / ((n + 1) * (n + 2))
        n += 2
    return -total if quarter_turns % 4 >= 2 else total


ELEMENTARY = {
    "sqrt": (fn.sqrt, Decimal.sqrt, True), "exp": (fn.exp, Decimal.exp, False), "log": (fn.log, Decimal.ln, True),
    "sin": (fn.sin, _decimal_sin, False), "cos": (fn.cos, lambda x: _decimal_sin(x, 1), False),
    "cbrt": (fn.cbrt, lambda x: (abs(x).ln() / 3).exp().copy_sign(x), False),
    "tan": (fn.tan, lambda x: _decimal_sin(x) / _decimal_sin(x, 1), False),
    "abs": (fn.absolute, Decimal.copy_abs, False)}


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("name", ELEMENTARY)
def test_outward_rounded_functions_hold_the_true_value(name, kind):
    phi, true, positive = ELEMENTARY[name]
    bounds = _bounds(4, positive, largest=1.0)
    xs = _samples(*bounds)
    low, high = enclose(phi, OutwardInterval, kind, bounds)
    with localcontext() as context:
        context.prec = 50
        assert_holds(low, high, lambda i, k: true(Decimal(float(xs[i, k]))))


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("name, pick", [("minimum", min), ("maximum", max)])
def test_the_smaller_and_the_larger_are_enclosed(name, pick, kind):
    a, b = _bounds(5), _bounds(6)
    xs, ys = _samples(*a), _samples(*b)
    low, high = enclose(getattr(fn, name), OutwardInterval, kind, a, b)
    assert_holds(low, high, lambda i, k: Fraction(pick(xs[i, k], ys[i, k])))


FORMULAS = {
    "torus": lambda x, y, z: (fn.sqrt(x**2 + y**2) - 2)**2 + z**2 - 0.25,
    "heart": lambda x, y, z: x**2 + z**2 * 2.25 + y**2 - 1 - y * fn.cbrt(x**2 + z**2 * 9 / 80),
    "gyroid": lambda x, y, z: fn.sin(x) * fn.cos(y) + fn.sin(y) * fn.cos(z) + fn.sin(z) * fn.cos(x),
    "mixture": lambda x, y, z: fn.exp(-(x**2)) / (1 + y**2) - fn.log(2 + fn.absolute(z)) + fn.minimum(x, y * z)}


@pytest.mark.parametrize("name", FORMULAS)
def test_values_and_gradients_of_formulas_are_enclosed(name):
    """Duals of intervals: 20 points of each of 60 random boxes; 1e-12 for rounding to nearest."""
    random = np.random.default_rng(7)
    low = random.uniform(-2, 2, (3, COUNT))
    high = low + 10.0**random.uniform(-3, 0.5, (3, COUNT))
    f = FORMULAS[name](*Dual.axes(tuple(Interval(a, b) for a, b in zip(low, high))))
    for _ in range(20):
        point = low + (high - low) * random.random((3, COUNT))
        g = FORMULAS[name](*Dual.axes(tuple(point)))
        for enclosure, value in [(f.value, g.value), *((f.derivative(k), g.derivative(k)) for k in range(3))]:
            assert np.all(enclosure.low - 1e-12 <= value) and np.all(value <= enclosure.high + 1e-12)


UNDEFINED = {
    "1/[-1, 1]": (lambda a: 1 / a, -1.0, 1.0), "1/[0, 1]": (lambda a: 1 / a, 0.0, 1.0),
    "1/[-1, 0]": (lambda a: 1 / a, -1.0, 0.0), "a/a": (lambda a: a / a, -1.0, 2.0),
    "[-1, 1]^-2": (lambda a: a**-2, -1.0, 1.0), "[0, 1]^-1": (lambda a: a**-1, 0.0, 1.0),
    "sqrt [-1, 4]": (fn.sqrt, -1.0, 4.0), "log [-1, 1]": (fn.log, -1.0, 1.0),
    "[-1, 4]^2.5": (lambda a: fn.power(a, 2.5), -1.0, 4.0), "[-1, 4]^0.3": (lambda a: fn.power(a, 0.3), -1.0, 4.0),
    "tan [1, 2]": (fn.tan, 1.0, 2.0)}


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("name", UNDEFINED)
@pytest.mark.filterwarnings("ignore:divide by zero")
def test_where_an_operation_is_undefined_nothing_is_concluded(name, kind):
    """A pole inside: the answer is the whole line. A root or a logarithm of a negative number: it is NaN, also of a function
    whose values are bounded."""
    phi, low, high = UNDEFINED[name]
    bounds = np.full(COUNT, low), np.full(COUNT, high)
    for number in (Interval, OutwardInterval):
        low, high = enclose(phi, number, kind, bounds)
        if any(function in name for function in ("sqrt", "log", ".")):
            for bounded in (fn.cos, fn.sin, lambda a: 1 / (1 + fn.exp(a)), lambda a: fn.minimum(a, 1.0), lambda a: 1 / a,
                            lambda a: 1 / (a - a), fn.tan, lambda a: a**2, lambda a: fn.power(a**2, 0.5), fn.absolute):
                low, high = enclose(lambda a: bounded(phi(a)), number, kind, bounds)
                assert np.all(np.isnan(low) | np.isnan(high))
        else:
            assert np.all(low == -math.inf) and np.all(high == math.inf)


TIGHT = {
    "log [0, 1]": (fn.log, 0.0, 1.0, (-math.inf, 0)), "[0, 4]^2.5": (lambda a: fn.power(a, 2.5), 0.0, 4.0, (0, 32)),
    "[0, 4]^0.3": (lambda a: fn.power(a, 0.3), 0.0, 4.0, (0, 4**0.3)),
    "sqrt [0, 4]": (fn.sqrt, 0.0, 4.0, (0, 2)), "[-1, 3]^2": (lambda a: a**2, -1.0, 3.0, (0, 9)),
    "a a": (lambda a: a * a, -3.0, 1.0, (0, 9)), "[-2, 1]^3": (lambda a: a**3, -2.0, 1.0, (-8, 1)),
    "cos [-1, 1]": (fn.cos, -1.0, 1.0, (math.cos(1), 1)), "sin [0, 4]": (fn.sin, 0.0, 4.0, (math.sin(4), 1)),
    "cos [0, 7]": (fn.cos, 0.0, 7.0, (-1, 1)), "cos [3, 3.5]": (fn.cos, 3.0, 3.5, (-1, math.cos(3.5))),
    "sin [-100, 100]": (fn.sin, -100.0, 100.0, (-1, 1))}


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("name", TIGHT)
def test_enclosures_are_tight_where_they_can_be(name, kind):
    phi, low, high, expected = TIGHT[name]
    found = enclose(phi, Interval, kind, (np.full(COUNT, low), np.full(COUNT, high)))
    np.testing.assert_allclose(np.stack(found), np.broadcast_to(np.array(expected)[:, None], (2, COUNT)), atol=1e-14)


def test_nan_never_passes_for_a_proof():
    nan = np.array([math.nan])
    for number in (Interval(nan, nan), Interval(nan, np.array([-1.0])), Interval(np.array([1.0]), nan)):
        assert not (number - number).excludes_zero()[0] and not (number * 0.0 + math.nan).excludes_zero()[0]
    assert Interval(np.array([1.0]), np.array([2.0])).excludes_zero()[0]
    assert not Interval(np.array([0.0]), np.array([2.0])).excludes_zero()[0]


def test_where_larger_keeps_both_branches_while_the_order_is_open():
    one, two, a, b = Interval(0.0, 1.0), Interval(2.0, 3.0), Interval(5.0), Interval(7.0)
    overlap = Interval(0.5, 2.5)
    bounds = lambda number: (number.low, number.high)
    assert bounds(fn.where_larger(two, one, a, b)) == (5, 5)
    assert bounds(fn.where_larger(one, two, a, b)) == (7, 7)
    assert bounds(fn.where_larger(one, overlap, a, b)) == (5, 7)


def test_outward_rounding_covers_results_that_underflow_in_every_thread():
    """1e-200 * 1e-200 = 1e-400 lies between 0 and the smallest float. 10^5 entries occupy Dr.Jit's thread pool, whose
    threads flush subnormal numbers to zero."""
    Float = backend().Float
    a = np.full(100_000, 1e-200)
    product = OutwardInterval(Float(a), Float(2 * a)) * OutwardInterval(Float(a), Float(2 * a))
    assert np.all(product.high.numpy() > 0) and np.all(product.low.numpy() <= 0)


def test_slopes_that_are_plain_numbers_keep_their_digits():
    """The slope of max(0.3 x, -0.7 x) is 0.3, -0.7 or between them: in double precision, not in single."""
    x = backend().Float([-2.0, -0.5, 1.0])
    value = Dual(OutwardInterval(x, x + 1), (1.0,))
    slope = OutwardInterval.of((value * 0.3).maximum(value * -0.7).derivative())
    low, high = (np.array(b) for b in (slope.low, slope.high))
    np.testing.assert_allclose(low, [-0.7, -0.7, 0.3], rtol=4e-16)
    np.testing.assert_allclose(high, [-0.7, 0.3, 0.3], rtol=4e-16)
    assert (low <= [-0.7, -0.7, 0.3]).all() and (high >= [-0.7, 0.3, 0.3]).all()


@pytest.mark.parametrize("formula", ["sin(10*x)", "exp(3*x)*y", "sqrt((2*x)**2 + 1)*tan(x/4)", "min(2*x, y)*3", "cbrt(x*5 + 7)/(2 - x/9)",
                                     "(x*2)**2.5 + atan2(3*x, y)", "mod(x*3, 2)*x", "smin(2*x, y*z, 0.5)"])
def test_slopes_by_parameters_of_kernels_are_enclosed(formula):
    """Numbers of a formula are arrays in kernels; the slope of 10 x is such an array, and no interval."""
    form, Float = forms_of(formula), backend().Float
    numbers = {name: Float(value) for name, value in form.parameters.items()}
    cube = tuple(OutwardInterval(Float(c - 1e-9), Float(c + 1e-9)) for c in (0.3, 0.4, 0.5))
    f, at = form.regular(*Dual.axes(cube), **numbers), form.regular(*Dual.axes((0.3, 0.4, 0.5)))
    for k in range(3):
        slope = OutwardInterval.of(f.derivative(k))
        assert Float(slope.low)[0] <= at.derivative(k) <= Float(slope.high)[0]
        assert Float(slope.high)[0] - Float(slope.low)[0] < 1e-5
