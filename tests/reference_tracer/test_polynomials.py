"""Polynomials of a ray: coefficients against exact rational arithmetic, degrees, and what is not a polynomial."""

from fractions import Fraction

import numpy as np
import pytest

from raytruth.reference_tracer.backend import backend
from raytruth.reference_tracer.numbers import NotAlgebraic, Polynomial
from raytruth.reference_tracer.numbers import functions as fn
from raytruth.reference_tracer.surfaces.heart import Heart

FUNCTIONS = {
    1: lambda x, y, z: x * 2 - y / 4 + (3 - z) + 1,
    2: lambda x, y, z: x**2 / 4 + y * z - 1,
    3: lambda x, y, z: -(x * y * z) + (1 - x)**2,
    5: lambda x, y, z: (x - y)**5 + (z**2 - 1)**2 * x**0,
    7: lambda x, y, z: (x + y)**3 * (y - z)**4,
    6: lambda x, y, z: (x**2 + z**2 * 9 / 4 + y**2 - 1)**3 - x**2 * y**3 - z**2 * y**3 * 9 / 80}
ORIGIN = (Fraction(1, 3), Fraction(-2, 5), Fraction(7, 4))
DIRECTION = (Fraction(2, 3), Fraction(1, 7), Fraction(-3, 5))


@pytest.mark.parametrize("degree", FUNCTIONS)
def test_coefficients_are_exact_on_rationals(degree):
    """g(t) = f(o + t d), evaluated directly in rational arithmetic at degree + 3 places: more than determine g."""
    f = FUNCTIONS[degree]
    g = f(*Polynomial.along(ORIGIN, DIRECTION))
    assert g.degree == degree and g.c[-1] != 0
    for t in map(Fraction, range(-1, degree + 2)):
        assert g(t) == f(*(o + t * d for o, d in zip(ORIGIN, DIRECTION)))


@pytest.mark.parametrize("degree", FUNCTIONS)
def test_coefficients_on_drjit_arrays_are_those_of_rational_arithmetic(degree):
    f, Float = FUNCTIONS[degree], backend().Float
    exact = [float(c) for c in f(*Polynomial.along(ORIGIN, DIRECTION)).c]
    lanes = lambda numbers: [Float([float(v)] * 3) for v in numbers]
    g = f(*Polynomial.along(lanes(ORIGIN), lanes(DIRECTION)))
    found = np.array([np.broadcast_to(c.numpy(), 3) for c in g.c])
    np.testing.assert_allclose(found, np.broadcast_to(np.array(exact)[:, None], found.shape),
                               atol=4e-15 * np.abs(exact).max())


def test_the_heart_s_polynomial_is_the_printed_one():
    """Section 7.1.6 in rational arithmetic; the class writes 9/4 as 2.25 and multiplies from the right."""
    g, exact = (f(*Polynomial.along(ORIGIN, DIRECTION)) for f in (Heart.f, FUNCTIONS[6]))
    np.testing.assert_allclose([float(c) for c in g.c], [float(c) for c in exact.c], rtol=1e-13)


@pytest.mark.parametrize("f", [
    fn.sqrt, fn.cbrt, fn.sin, fn.cos, fn.tan, fn.exp, fn.log, fn.absolute, lambda x: fn.minimum(x, 1),
    lambda x: fn.maximum(1, x), lambda x: x**-1, lambda x: 1 / x, lambda x: x / x])
def test_what_is_not_a_polynomial_says_so(f):
    with pytest.raises(NotAlgebraic):
        f(Polynomial((1.0, 2.0)))
