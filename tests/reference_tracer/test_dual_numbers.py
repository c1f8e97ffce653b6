"""Dual numbers: values and first derivatives against derivatives written by hand and against finite differences."""

import math

import numpy as np
import pytest

from raytruth.reference_tracer.backend import backend
from raytruth.reference_tracer.numbers import Dual
from raytruth.reference_tracer.numbers import functions as fn

X = np.array([-2.5, -0.75, -0.3, 0.3, 0.4, 0.75, 1.9, 2.5])
POSITIVE = X > 0

# phi, phi' by hand, and where phi is defined
FUNCTIONS = {
    "sum": (lambda x: x + 2 - (1 - x) + (x - 3), lambda x: 3 + 0 * x, X < 9),
    "negation": (lambda x: -x, lambda x: -1 + 0 * x, X < 9),
    "product": (lambda x: x * (x + 2) * 3, lambda x: 6 * x + 6, X < 9),
    "own product": (lambda x: x * x, lambda x: 2 * x, X < 9),
    "quotient": (lambda x: (x + 1) / (x - 4), lambda x: -5 / (x - 4)**2, X < 9),
    "quotient by a number": (lambda x: x / 4, lambda x: 0.25 + 0 * x, X < 9),
    "reciprocal": (lambda x: 2 / x, lambda x: -2 / x**2, X < 9),
    "power 0": (lambda x: x**0, lambda x: 0 * x, X < 9),
    "power 1": (lambda x: x**1, lambda x: 1 + 0 * x, X < 9),
    "power 2": (lambda x: x**2, lambda x: 2 * x, X < 9),
    "power 5": (lambda x: x**5, lambda x: 5 * x**4, X < 9),
    "power -3": (lambda x: x**-3, lambda x: -3 / x**4, X < 9),
    "power 2.5": (lambda x: fn.power(x, 2.5), lambda x: 2.5 * x * np.sqrt(np.abs(x)), POSITIVE),
    "power -0.3": (lambda x: fn.power(x, -0.3), lambda x: -0.3 * x**-1.3, POSITIVE),
    "power x": (lambda x: fn.power(x, x), lambda x: x**x * (1 + np.log(x)), POSITIVE),
    "power of a number": (lambda x: fn.power(2.0, x), lambda x: 2.0**x * math.log(2), X < 9),
    "sqrt": (fn.sqrt, lambda x: 0.5 / np.sqrt(x), POSITIVE),
    "cbrt": (fn.cbrt, lambda x: 1 / (3 * np.cbrt(x)**2), X < 9),
    "sin": (fn.sin, np.cos, X < 9),
    "cos": (fn.cos, lambda x: -np.sin(x), X < 9),
    "tan": (fn.tan, lambda x: 1 / np.cos(x)**2, X < 9),
    "exp": (fn.exp, np.exp, X < 9),
    "log": (fn.log, lambda x: 1 / x, POSITIVE),
    "abs": (fn.absolute, np.sign, X < 9),
    "min": (lambda x: fn.minimum(x, x**2), lambda x: np.where((0 < x) & (x < 1), 2 * x, 1), X < 9),
    "min with a number": (lambda x: fn.minimum(0.5, x), lambda x: np.where(x < 0.5, 1.0, 0), X < 9),
    "max": (lambda x: fn.maximum(x, x**2), lambda x: np.where((0 < x) & (x < 1), 1, 2 * x), X < 9),
    "max with a number": (lambda x: fn.maximum(x, 0.5), lambda x: np.where(x > 0.5, 1.0, 0), X < 9),
    "chain": (lambda x: fn.sin(fn.exp(x) / (x**2 + 1)),
              lambda x: np.cos(np.exp(x) / (x**2 + 1)) * np.exp(x) * (x - 1)**2 / (x**2 + 1)**2, X < 9),
}


def _on_floats(phi, x):
    results = [phi(Dual(float(value), (1.0,))) for value in x]
    return np.array([r.value for r in results]), np.array([r.derivative() for r in results])


def _on_numpy(phi, x):
    result = phi(Dual(x, (np.ones_like(x),)))
    return result.value, np.broadcast_to(result.derivative(), x.shape)


def _on_drjit(phi, x):
    Float = backend().Float
    result = phi(Dual(Float(x), (Float(np.ones_like(x)),)))
    wide = lambda value: np.broadcast_to(Float(value).numpy(), x.shape)
    return wide(result.value), wide(result.derivative())


@pytest.mark.parametrize("evaluate", [_on_floats, _on_numpy, _on_drjit])
@pytest.mark.parametrize("name", FUNCTIONS)
def test_derivatives_equal_those_by_hand(name, evaluate):
    phi, slope, defined = FUNCTIONS[name]
    x = X[defined]
    value, derivative = evaluate(phi, x)
    np.testing.assert_allclose(value, [phi(float(v)) for v in x], rtol=4e-15, atol=1e-15)
    np.testing.assert_allclose(derivative, slope(x), rtol=4e-15, atol=1e-15)


@pytest.mark.parametrize("name", FUNCTIONS)
def test_derivatives_equal_finite_differences(name):
    """(phi(x + h) - phi(x - h)) / 2h errs by phi''' h^2 / 6: 1e-10 times phi''' (up to 5e3 at 0.3^-4) for h = 1e-5."""
    phi, _, defined = FUNCTIONS[name]
    x, h = X[defined], 1e-5
    _, derivative = _on_numpy(phi, x)
    np.testing.assert_allclose(derivative, (phi(x + h) - phi(x - h)) / (2 * h), rtol=1e-6, atol=1e-8)


def test_axes_carry_the_gradient():
    """f = x y / z + sin(x) exp(y) - z^3: grad f = (y/z + cos x e^y, x/z + sin x e^y, -x y/z^2 - 3 z^2)."""
    x, y, z = 0.7, -0.4, 1.3
    a, b, c = Dual.axes((x, y, z))
    f = a * b / c + fn.sin(a) * fn.exp(b) - c**3
    expected = (y / z + math.cos(x) * math.exp(y), x / z + math.sin(x) * math.exp(y), -x * y / z**2 - 3 * z**2)
    assert [f.derivative(k) for k in range(3)] == pytest.approx(expected, rel=4e-16)
    assert f.value == pytest.approx(x * y / z + math.sin(x) * math.exp(y) - z**3)


def test_a_derivative_known_to_be_zero_costs_nothing_and_reads_as_zero():
    a, b, _ = Dual.axes((0.7, -0.4, 1.3))
    assert (a * 3 + fn.cos(a)).derivatives[1:] == (None, None)
    assert (a * 3).derivative(1) == 0.0
    assert fn.maximum(a, b).derivatives[2] is None and fn.maximum(a, b).derivative(1) == 0.0


def test_along_a_ray_it_gives_g_and_its_slope():
    """f = x^2 + y^2 + z^2 - 1 on o + t d: g(0) = o.o - 1, g'(0) = 2 o.d."""
    o, d = np.array([1.0, 2.0, -3.0]), np.array([0.6, 0.0, 0.8])
    x, y, z = Dual.along(o, d)
    g = x**2 + y**2 + z**2 - 1
    assert (g.value, g.derivative()) == (o @ o - 1, pytest.approx(2 * o @ d))


def test_the_tangent_of_tiny_numbers_keeps_its_digits_on_drjit():
    """tan x = x + x^3/3 + ...; drjit.tan of 9e-5 is off by a relative 3e-9, the size of its second term."""
    x = np.array([9e-5, 1e-7, -1e-9, 1e-300])
    np.testing.assert_allclose(fn.tan(backend().Float(x)).numpy(), np.tan(x), rtol=7e-16)


@pytest.mark.parametrize("function, x, value", [
    (fn.sqrt, -1.0, math.nan), (fn.log, -1.0, math.nan), (fn.log, 0.0, -math.inf), (fn.exp, 1e6, math.inf),
    (fn.sin, math.inf, math.nan), (fn.cbrt, -8.0, -2.0), (fn.sqrt, 0.0, 0.0)])
def test_outside_of_its_domain_a_function_answers_as_ieee_arithmetic_does(function, x, value):
    np.testing.assert_equal(function(x), value)
    np.testing.assert_equal(function(np.array([x]))[0], value)
    np.testing.assert_equal(function(backend().Float([x])).numpy()[0], value)
