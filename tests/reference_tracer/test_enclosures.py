"""Every number type against python-flint on random arguments of every size; what is broken must be seen as broken."""

import math

import enclosures
import numpy as np
import pytest
from enclosures import CASES, FLOATS, KINDS, Kind, check, float_errors
from flint import arb

from raytruth.reference_tracer.backend import backend, use_threads
from raytruth.reference_tracer.certify.search import precision
from raytruth.reference_tracer.numbers import Dual, Interval, NotAlgebraic, OutwardInterval, Polynomial, interval
from raytruth.reference_tracer.numbers import functions as fn
from raytruth.reference_tracer.numbers.exact import RationalPolynomial, Series
from raytruth.reference_tracer.oracle.literal import Tangent
from raytruth.reference_tracer.surfaces.expression import forms_of

NAMED = {case.name: case for case in CASES}
PROOFS = [kind for kind in KINDS if kind.number is OutwardInterval]


@pytest.mark.parametrize("name", NAMED)
def test_no_true_value_or_derivative_lies_outside(name):
    for result in check(NAMED[name], 2000):
        assert result.outside == 0, result


@pytest.mark.parametrize("on_drjit", [False, True])
@pytest.mark.parametrize("name", FLOATS)
def test_functions_of_floats_err_by_no_more_than_is_granted(name, on_drjit):
    error, granted = float_errors(name, 2000, on_drjit)
    assert error <= granted


def _outside(name: str, kinds=PROOFS, series=False, count=4000) -> int:
    return sum(result.outside for result in check(NAMED[name], count, kinds=kinds, series=series))


@pytest.mark.parametrize("name", ["cbrt", "exp", "log"])
def test_a_function_without_outward_rounding_is_found(name, monkeypatch):
    monkeypatch.setitem(interval.ULPS, name, 0)
    assert _outside(name) > 0


@pytest.mark.parametrize("name", ["a + b", "a b", "a / b", "a^3", "a ** 2.5"])
def test_arithmetic_that_rounds_to_nearest_is_found(name, monkeypatch):
    monkeypatch.setattr(OutwardInterval, "rounded",
                        classmethod(lambda cls, low, high, ulps=1, nonnegative=False: cls(low, high, nonnegative)))
    assert _outside(name) > 0


@pytest.mark.parametrize("name", ["a b", "a^3", "a / b"])
def test_underflow_that_is_not_covered_is_found(name, monkeypatch):
    monkeypatch.setattr(interval, "_TINY", 0.0)
    use_threads(2)  # Dr.Jit's threads flush what is subnormal; a single one, that of Python, does not
    assert _outside(name) > 0


@pytest.mark.parametrize("name", ["sin", "cos", "tan"])
def test_angles_too_large_to_be_reduced_are_found(name, monkeypatch):
    monkeypatch.setattr(fn, "LARGEST_ANGLE", math.inf)
    assert _outside(name, [Kind(OutwardInterval, True)]) > 0


def test_cosine_without_its_peaks_is_found(monkeypatch):
    monkeypatch.setattr(OutwardInterval, "_holds", lambda self, angle, period, reach: reach < 0)
    assert _outside("cos") > 0 and _outside("sin") > 0 and _outside("tan") > 0


@pytest.mark.parametrize("name", ["sqrt", "log", "a ** 2.5", "a ** 0.3"])
def test_claims_beyond_the_domain_are_found(name, monkeypatch):
    monkeypatch.setattr(OutwardInterval, "_where", classmethod(lambda cls, holds, result, *others, **more: result))
    assert _outside(name) > 0


def test_a_wrong_derivative_is_found(monkeypatch):
    monkeypatch.setattr(Dual, "cos", lambda self: self._chain(fn.cos(self.value), fn.sin(self.value)))
    assert _outside("cos") > 0
    monkeypatch.setattr(Dual, "sqrt", lambda self: self._chain(fn.sqrt(self.value), fn.sqrt(self.value)))
    assert _outside("sqrt") > 0


def test_a_wrong_series_is_found(monkeypatch):
    monkeypatch.setattr(Series, "sqrt", lambda self: Series(abs(self.s[0]).sqrt() + 0 * self.s, True))
    assert _outside("sqrt", [], series=True) > 0


def test_the_command_prints_a_table_and_fails_where_something_lies_outside(capsys, monkeypatch):
    assert enclosures.main(["--count", "400", "--only", "sqrt"]) == 0
    assert "OutwardInterval on Dr.Jit" in (table := capsys.readouterr().out) and table.endswith("\n0 outside\n")
    monkeypatch.setattr(enclosures.stated, "ULPS", {**interval.ULPS, "sqrt": 0.25})
    assert enclosures.main(["--count", "400", "--only", "sqrt"]) == 1
    with pytest.raises(SystemExit):
        enclosures.main(["--count", "0"])


SPECIAL = [0.0, -0.0, 1.0, -1.0, 2.0, 1e-200, -1e-200, 1e200, -1e200, math.inf, -math.inf, math.nan]
SPECIAL_FUNCTIONS = {
    "1 / x": lambda x: 1 / x, "x / x": lambda x: x / x, "2 / x^2": lambda x: 2 / x**2, "x^3": lambda x: x**3,
    "x^-2": lambda x: x**-2, "sqrt": fn.sqrt, "cbrt": fn.cbrt, "log": fn.log, "exp": fn.exp, "abs": fn.absolute,
    "x ** 2.5": lambda x: fn.power(x, 2.5), "x ** 0.3": lambda x: fn.power(x, 0.3), "x ** 1.2": lambda x: fn.power(x, 1.2),
    "x ** -0.5": lambda x: fn.power(x, -0.5), "2 ** x": lambda x: fn.power(2.0, x), "min": lambda x: fn.minimum(x, 0.5)}


@pytest.mark.parametrize("name", SPECIAL_FUNCTIONS)
@pytest.mark.filterwarnings("error")
def test_what_is_not_finite_is_the_same_on_floats_and_arrays(name):
    """Division by zero, overflow and NaN are values, as IEEE 754 has them; floats of Python would raise exceptions."""
    phi, Float = SPECIAL_FUNCTIONS[name], backend().Float
    floats = [phi(Dual(v, (1.0,))) for v in SPECIAL]
    with np.errstate(all="ignore"):
        arrays = phi(Dual(np.array(SPECIAL), (np.ones(len(SPECIAL)),)))
    drjit = phi(Dual(Float(SPECIAL), (Float(1.0),)))
    for of_floats, of_arrays, on_drjit in (([f.value for f in floats], arrays.value, drjit.value),
                                           ([f.derivative() for f in floats], arrays.derivative(), drjit.derivative())):
        np.testing.assert_allclose(of_floats, of_arrays, rtol=4e-15)
        np.testing.assert_allclose(np.broadcast_to(Float(on_drjit).numpy(), len(SPECIAL)), of_arrays, rtol=4e-13)


@pytest.mark.parametrize("name", ["sin", "cos", "tan"])
def test_waves_of_floats_are_right_or_nan(name):
    """Beyond LARGEST_ANGLE Dr.Jit returns numbers of any size; decided they must not be (M7)."""
    x = np.array([0.5, 1e3, 1e9, 1.5 * fn.LARGEST_ANGLE, 1e10, 1e300, math.inf, math.nan])
    wave = getattr(fn, name)
    found = wave(backend().Float(x)).numpy()
    np.testing.assert_array_equal(np.isnan(found), ~(x <= fn.LARGEST_ANGLE))
    np.testing.assert_allclose(found[:3], wave(x[:3]), rtol=1e-14)


def test_a_power_at_zero_has_the_value_and_the_slope_it_has():
    for zero in (0.0, -0.0):
        power = fn.power(Dual(zero, (1.0,)), 1.25)
        assert (power.value, power.derivative()) == (0, 0)
        power = fn.power(Dual(zero, (1.0,)), 0.75)
        assert (power.value, power.derivative()) == (0, math.inf)


def test_a_power_over_a_ball_that_reaches_zero_keeps_the_derivatives_that_exist():
    """|x|^p about 0: all of value, p x^(p-1) and p (p-1)/2 x^(p-2) lie between 0 and their value at the end, 0.1."""
    from flint import arb, arb_series

    from raytruth.reference_tracer.certify.search import precision
    with precision(96):
        x = Series(arb_series([arb(0.05, 0.05), arb(1)]), nonnegative=True)
        for p, existing in ((2.5, 3), (1.5, 2), (0.5, 1)):
            found = fn.power(x, p).s
            for k, scale in enumerate((1, p, p * (p - 1) / 2)):
                assert found[k].is_finite() == (k < existing)
                if k < existing:
                    assert found[k].contains(arb(0)) and found[k].contains(scale * arb(0.1)**(p - k) * arb(0.999))
                    assert float(found[k].upper()) < 1.001 * scale * 0.1**(p - k)
        assert not fn.power(Series(arb_series([arb(0, 0.1), arb(1)])), 2.5).s[0].is_finite()


def test_a_sum_of_squares_is_no_negative_number_whatever_rounding_does_to_it():
    """Outward rounding pushes 0 + 0 below zero, times 1e300 far below; the square root is defined nevertheless, while that
    of 1e-300 x is not defined at x = -1."""
    for array in (np.asarray, backend().Float):
        x, y = (OutwardInterval(array([0.0, -1.0]), array([0.0, 2.0])) for _ in range(2))
        root = fn.sqrt((x**2 + y * y) * 1e300)
        assert np.all(np.asarray(root.low) >= 0) and np.all(np.asarray(root.high) < 4e150)
        factors = array([1e300, 2e300])  # arrays, as parameters of a family are
        assert np.all(np.asarray(fn.sqrt(x**2 * factors + y * y).high) < 4e150)
        assert np.all(np.isnan(np.asarray(fn.sqrt(x**2 * -factors + y * y).high)))
        assert np.all(np.isnan(np.asarray(fn.sqrt(OutwardInterval(array([-1.0, -1.0]), array([1.0, 1.0])) * 1e-300).low)))


def test_the_absolute_value_of_an_interval_is_not_negative():
    for low, high, expected in ((-2.0, 1.0, (0, 2)), (-3.0, -1.0, (1, 3)), (1.0, 2.0, (1, 2))):
        absolute = fn.absolute(Dual(OutwardInterval(low, high), (1.0,)))
        assert (absolute.value.low, absolute.value.high) == expected


@pytest.mark.filterwarnings("ignore:invalid value")
def test_overflow_bounds_nothing():
    """What is beyond the largest float comes back as a side that is open, also where it would be made small again."""
    for array in (np.asarray, backend().Float):
        huge = OutwardInterval(array([1e200, 1e200]), array([2e200, 2e200]))
        square = huge * huge
        assert not np.any(np.asarray((square - square).excludes_zero()))
        small = 1 / (square * square)
        assert not np.any(np.asarray(small.low) > 0) and not np.any(np.asarray(small.high) < 1e-300)


def test_a_subnormal_factor_is_not_read_as_zero():
    Float = backend().Float
    product = OutwardInterval(Float(np.full(100_000, 1e300))) * 1e-310
    assert np.all(product.low.numpy() <= 1e-10) and np.all(product.high.numpy() >= 1e-10)


@precision(enclosures.BITS)
def _ordinary(case, count=300):
    """Arguments of size one, and the true values and slopes there (None where one is not asked for)."""
    points = np.random.default_rng(7).uniform(-2.5, 2.5, (case.arity, count))
    balls = [[arb(v) for v in p.tolist()] for p in points]
    value = [case.true(*p) for p in zip(*balls)]
    slope = [case.slope(*p) if v.is_finite() else None for v, *p in zip(value, *balls)]
    number = lambda v: float(v) if v is not None and v.is_finite() else math.nan
    return points, np.array(list(map(number, value))), np.array(list(map(number, slope)))


def _holds(found, true):
    """Found is what is true, to the digits that cancellation leaves; where there is no true value nothing is asked."""
    known = np.isfinite(true)
    np.testing.assert_allclose(np.broadcast_to(found, true.shape)[known], true[known], rtol=2e-12, atol=2e-13)


@pytest.mark.parametrize("name", NAMED)
def test_every_function_and_its_slope_on_every_number_type(name):
    """Floats, NumPy, Dr.Jit, duals on all three, and the derivatives of the recursive oracle, against flint's balls."""
    case, Float = NAMED[name], backend().Float
    points, value, slope = _ordinary(case)
    with np.errstate(all="ignore"):
        _holds([case.phi(*p) for p in points.T.tolist()], value)
        _holds(case.phi(*points), value)
        _holds(np.array(Float(case.phi(*map(Float, points)))), value)
        undefined = ~np.isfinite(value)
        assert not np.isfinite(np.broadcast_to(case.phi(*points), value.shape)[undefined]).any()
        dual = case.phi(*(Dual(p, (np.full(len(value), s),)) for p, s in zip(points, enclosures.SLOPES)))
        _holds(dual.value, value)
        _holds(dual.derivative(), slope)
        recorded = case.phi(*(Dual(Float(p), (Float(s),)) for p, s in zip(points, enclosures.SLOPES)))
        _holds(np.array(Float(recorded.derivative())), slope)
        tangent = Tangent.of(case.phi(*(Tangent(p, np.full((1, len(value)), s)) for p, s in zip(points, enclosures.SLOPES))))
        _holds(tangent.value, value)
        _holds(np.broadcast_to(tangent.slopes, (1, len(value)))[0], slope)


@pytest.mark.parametrize("name", [c.name for c in CASES[[c.name for c in CASES].index("floor"):] if c.name != "mix"])
def test_what_is_no_polynomial_is_none(name):
    """A function that jumps or is transcendental must not pass for a ray's polynomial."""
    case = NAMED[name]
    for x in (Polynomial((0.3, 1.0)), RationalPolynomial.along((0.3,), (1.0,))[0]):
        with pytest.raises(NotAlgebraic):
            case.phi(*[x] * case.arity)


@pytest.mark.parametrize("name", ["floor", "ceil", "fract", "heaviside", "sign", "mod"])
def test_a_slope_across_a_jump_is_found(name, monkeypatch):
    """Were the slope across a jump 0, a monotone function could pass for one that it is not."""
    monkeypatch.setattr(OutwardInterval, "flat_slope", lambda self, function: OutwardInterval(0.0))
    f = lambda x: NAMED[name].phi(*[x, 1.0][:NAMED[name].arity])
    assert np.isfinite(f(Dual(OutwardInterval(-0.5, 0.5), (1.0,))).derivative().low)
    monkeypatch.undo()
    slope = f(Dual(OutwardInterval(-0.5, 0.5), (1.0,))).derivative()
    assert math.isnan(slope.low) and math.isnan(slope.high)


def test_both_sides_of_a_jump_are_enclosed_and_no_more():
    """(mod(x, 1) - 1/2)^2 is 1/4 on both sides of 1 and 0 nowhere near it; three whole numbers are more than two sides."""
    f = forms_of("(mod(x, 1) - 0.5)^2 + 0*y").function
    for number in (Interval, OutwardInterval):
        one, many = number(0.9, 1.1), number(0.2, 2.3)
        assert 0.15 < f(one, 0.0, 0.0).low and f(one, 0.0, 0.0).high < 0.37 and f(many, 0.0, 0.0).low <= 0
        for x in (one, many):
            value = f(x, 0.0, 0.0)
            assert all(value.low <= (t % 1 - 0.5)**2 <= value.high for t in np.linspace(x.low, x.high, 100).tolist())
    with precision(96):
        ball = f(*Series.along((0.9, 0, 0), (1, 0, 0), arb(0.1, 0.1))).s
        assert ball[0] > 0.1 and not ball[1].is_finite()
        assert f(*Series.along((0.2, 0, 0), (1, 0, 0), arb(0.1, 0.05))).s[1].is_finite()


@pytest.mark.parametrize("name", NAMED)
def test_no_function_falls_to_single_precision(name):
    """Of two Python numbers Dr.Jit's select makes one of single precision; a kernel's loop then refuses to change its type."""
    case, Float = NAMED[name], backend().Float
    arrays = [Float([0.25, -0.5]), Float([0.75, 0.5])][:case.arity]
    assert type(case.phi(*arrays)) is Float
    for number in (Interval, OutwardInterval):
        result = case.phi(*(Dual(number(a, a + 0.125), (number(Float(1.0)),)) for a in arrays))
        for part in (result.value, number.of(result.derivative())):
            assert {type(part.low), type(part.high)} <= {Float, float, int}, name
