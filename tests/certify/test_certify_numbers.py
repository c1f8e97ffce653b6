"""The number types of python-flint: floats enter exactly, balls hold what they claim to hold."""

import math
from fractions import Fraction

import pytest
from flint import arb, arb_series, fmpq

from raytruth.reference_tracer.certify.search import precision
from raytruth.reference_tracer.numbers import NotAlgebraic
from raytruth.reference_tracer.numbers import functions as fn
from raytruth.reference_tracer.numbers.exact import RationalPolynomial, Series, rational


def _fractions(polynomial) -> list[Fraction]:
    return [Fraction(int(c.p), int(c.q)) for c in polynomial.p.coeffs()]


def test_floats_enter_as_the_dyadic_numbers_they_are():
    assert rational(0.1) == fmpq(3602879701896397, 2**55)
    x, y, z = RationalPolynomial.along((0.1, 0.2, 0.3), (0.5, 0.25, 0.0))
    a, b = Fraction(0.1), Fraction(0.2)
    assert _fractions(x * y + 0.7) == [a * b + Fraction(0.7), a / 4 + b / 2, Fraction(1, 8)]
    assert _fractions(2.5 - x**2 / 3) == [Fraction(2.5) - a * a / 3, -a / 3, Fraction(-1, 12)]
    assert _fractions(-z) == [-Fraction(0.3)]


def test_what_is_not_a_polynomial_is_refused():
    x, _, _ = RationalPolynomial.along((0.1, 0.2, 0.3), (0.5, 0.25, 0.0))
    for attempt in (lambda: fn.sqrt(x), lambda: 1 / x, lambda: fn.maximum(x, 0.0), lambda: x**-1, lambda: fn.power(x, 0.5),
                    lambda: 1 / (x - x), lambda: x / 0.0):
        with pytest.raises(NotAlgebraic):
            attempt()


# value, first and half the second derivative in t of phi(x0 + t), by hand
SMOOTH = {
    "sqrt": (fn.sqrt, lambda x: (math.sqrt(x), 0.5 / math.sqrt(x), -0.125 * x**-1.5)),
    "cbrt": (fn.cbrt, lambda x: (x**(1 / 3), x**(-2 / 3) / 3, -x**(-5 / 3) / 9)),
    "sin": (fn.sin, lambda x: (math.sin(x), math.cos(x), -0.5 * math.sin(x))),
    "cos": (fn.cos, lambda x: (math.cos(x), -math.sin(x), -0.5 * math.cos(x))),
    "tan": (fn.tan, lambda x: (math.tan(x), 1 + math.tan(x)**2, math.tan(x) * (1 + math.tan(x)**2))),
    "exp": (fn.exp, lambda x: (math.exp(x), math.exp(x), 0.5 * math.exp(x))),
    "log": (fn.log, lambda x: (math.log(x), 1 / x, -0.5 / x**2)),
    "absolute": (lambda x: fn.absolute(-x), lambda x: (x, 1.0, 0.0)),
    "power": (lambda x: x**-3, lambda x: (x**-3, -3 * x**-4, 6 * x**-5)),
    "maximum": (lambda x: fn.maximum(x * x, 0.01), lambda x: (x * x, 2 * x, 1.0))}


@pytest.mark.parametrize("name", SMOOTH)
def test_a_series_holds_its_functions_value_and_derivatives_over_a_ball(name):
    """Over the ball 0.7 +- 0.05, at nine of its points; the ball of a point is thin."""
    function, expected = SMOOTH[name]
    with precision(96):
        wide = function(Series.along((0,), (1,), arb(0.7, 0.05))[0]).s
        for k in range(9):
            x = 0.65 + 0.0125 * k
            for i, value in enumerate(expected(x)):
                slack = arb(0, 1e-14 * (1 + abs(value)))
                assert (wide[i] + slack).contains(arb(value)), (x, i)
        point = function(Series.along((0,), (1,), arb(0.7))[0]).s
        assert all(float(point[i].rad()) < 1e-24 for i in range(3))


def test_a_kink_keeps_both_slopes_and_a_cusp_none():
    with precision(96):
        x = Series(arb_series([arb(0, 0.1), arb(1)]))
        kink = fn.absolute(x).s
        assert kink[1].contains(arb(1)) and kink[1].contains(arb(-1)) and not kink[2].is_finite()
        for cusp in (fn.cbrt(x).s, fn.sqrt(x**2).s):
            assert cusp[0].contains(arb(0)) and cusp[0].is_finite() and not cusp[1].is_finite()
        assert fn.cbrt(x).s[0].contains(arb(-0.1).neg().root(3).neg())
        for undefined in (fn.log(x), 1 / x, fn.sqrt(x)):
            assert not undefined.s[0].is_finite()
