"""The form of a formula that exact methods trace: its solid, whatever the multiplicity and the scale in which f is written."""

import random
import re
from fractions import Fraction

import numpy as np
import pytest
from flint import fmpq
from tracing_support import make_scene, shine, shoot, thing

from raytruth.reference_tracer.certify.line import follow, ray_polynomial
from raytruth.reference_tracer.numbers.exact import RationalPolynomial
from raytruth.reference_tracer.surfaces import Expression
from raytruth.reference_tracer.surfaces.exact_polynomial import polynomial
from raytruth.reference_tracer.surfaces.expression import forms_of
from raytruth.reference_tracer.surfaces.formula import FormulaError
from raytruth.reference_tracer.surfaces.formula_parser import parse_formula
from raytruth.reference_tracer.tracer.render import UNDECIDED, render

BALL = "(x**2 + y**2 + z**2 - 1)"
SMALL = "((x - 10)**2 + (y - 3)**2 + z**2 - 0.01)"
BOX = {"bounds": {"low": [-1.01] * 3, "high": [1.01] * 3}}
PLACE = (0.3, -0.2, 4.0)


def expanded(formula: str) -> str:
    """The polynomial `formula` written as a sum of monomials, if doubles hold its coefficients exactly."""
    terms = []
    for exponents, c in polynomial(parse_formula(formula)).to_dict().items():
        value = Fraction(int(c.p), int(c.q))
        assert Fraction(float(value)) == value
        powers = [f"{name}**{n}" if n > 1 else name for name, n in zip("xyz", map(int, exponents)) if n]
        terms.append("+-"[value < 0] + "*".join([f"{abs(float(value))!r}", *powers]))
    return "".join(terms)


def signs(formula: str, points) -> list[tuple[int, int]]:
    """The exact signs of f and of its regular form."""
    surface, found = Expression(formula=formula), []
    numbers = {name: RationalPolynomial.constant(v) for name, v in surface.parameters.items()}
    for point in points:
        at = RationalPolynomial.along(point, (fmpq(0),) * 3)
        values = [form(*at, **numbers) for form in (surface.function, surface.regular_form)]
        found.append(tuple((v.p[0] > 0) - (v.p[0] < 0) for v in values))
    return found


def points(chance: random.Random, count: int) -> list[tuple]:
    return [tuple(fmpq(chance.randrange(-3000, 3000), 1000) + c for c in chance.choice([(0, 0, 0), (10, 3, 0)]))
            for _ in range(count)]


# --- the sign ----------------------------------------------------------------------------------------------------------
FACTORS = [BALL, SMALL, "(x - y)", "(x + 2*y - z + 0.25)", "z", "(x**3 - y*z + 0.125)", "(x**2 + y**2)", "(x*y - 1)",
           "(x**2 - y**2)", "(x**2 + 1)", "(x - 0.125)", "(-3)", "1e-200", "1e150", "(-1)"]


def test_O6_the_regular_form_has_the_sign_of_f():
    """f < 0 and form < 0 are one set, apart from points where f is zero; in exact arithmetic, at random points."""
    forms_of.cache_clear()
    chance, changed = random.Random(5), 0
    for k in range(400):
        parts = [f"{chance.choice(FACTORS)}**{chance.choice([1, 1, 2, 3, 4, 5])}" for _ in range(chance.randrange(1, 4))]
        formula = chance.choice(["", "-"]) + "*".join(parts)
        try:
            formula = expanded(formula) if k % 2 else formula
            forms = forms_of(formula)
        except (FormulaError, AttributeError, AssertionError, OverflowError):  # too large to write out, or constant
            continue
        changed += forms.regular is not forms.function
        for of_f, of_form in signs(formula, points(chance, 6)):
            assert of_f in (0, of_form), formula
    assert changed > 100


@pytest.mark.parametrize("formula, form", [
    (f"{BALL}**5", BALL), (f"-{BALL}**3*2", f"-{BALL}"), (f"{BALL}**3/(-1e-300)", f"-{BALL}"), (f"(-{BALL})**3", f"-{BALL}"),
    (f"(-{BALL})**2*(x - y)", "x - y"), (f"{BALL}**2*(x - y)**3*(1 + x**2)", "x - y"), (f"exp(x)*{BALL}**3", BALL),
    (f"cbrt({BALL})", BALL), (f"cbrt({BALL}*abs(x))", BALL), (f"{BALL}**3/(1 + exp(y))", BALL), ("x*x*x", "x"),
    ("(exp(x) - 2)**3*(exp(x) - 2)**4", "exp(x) - 2"), (f"max({BALL}**3, -z*1e200)", f"max({BALL}, -z)"),
    (f"sqrt(x)*{BALL}**3", f"sqrt(x)*{BALL}"), (f"x**-1*{BALL}**3", f"x**-1*{BALL}"), (f"x**-2*{BALL}**3", f"x**-2*{BALL}"),
    ("(x - 1)*(x**2 - 1)", "x + 1"), ("1.5*(x - y)", "1.5*(x - y)"), ("x**2 - y**2", "x**2 - y**2"),
    (f"{BALL}*1e-300", BALL), ("1e-200*x - 1e-200*y", "1.25*x - 1.25*y")])
def test_the_form_of_a_product(formula, form):
    """Its values are those of `form` up to a positive factor, and it is undefined where f is."""
    a, b = Expression(formula=formula), Expression(formula=form)
    at = np.random.default_rng(3).uniform(-2, 2, (3, 50))
    with np.errstate(all="ignore"):
        f, value, expected = a.function(*at), a.regular_form(*at), b.function(*at)
    assert np.array_equal(np.isnan(f), np.isnan(value))
    ratio = (value / expected)[~np.isnan(f)]
    assert ratio.min() > 0 and np.ptp(ratio) < 1e-12 * ratio.max()


@pytest.mark.parametrize("formula", [f"{BALL}**2", f"-{BALL}**4", "abs(x)", "(x - y)**2*(z - 1)**2", expanded(f"{BALL}**2"),
                                     "x**2", f"sqrt({BALL}**2)"])
@pytest.mark.parametrize("method", ["exact", "interval", "descartes", "proof"])
def test_O6_a_formula_that_never_changes_sign_has_no_surface(formula, method):
    picture = render(make_scene(thing("expression", PLACE, formula=formula, **BOX), size=(16, 16)), method)
    assert (picture.index == -1).all() and (picture.status != UNDECIDED).all()


# --- pictures ----------------------------------------------------------------------------------------------------------
def picture(formula: str, method="exact", size=(48, 36), box=BOX, **changes):
    floor = thing("plane", (0, -1, 0), a=0, b=1, c=0)
    return render(make_scene(thing("expression", PLACE, formula=formula, **box, **changes), floor,
                             lights=[((3, 4, -3), (1, 1, 1))], size=size), method)


def assert_is_the_ball(formula: str, t_error=2e-14):
    found, ball = picture(formula), picture(BALL)
    assert (found.status != UNDECIDED).all()
    np.testing.assert_array_equal(found.index, ball.index)
    np.testing.assert_allclose(found.t[ball.index >= 0], ball.t[ball.index >= 0], rtol=t_error)
    np.testing.assert_allclose(found.color, ball.color, atol=2e4 * t_error)


@pytest.mark.parametrize("n", [3, 5, 7, 9, 31])
def test_O6_an_odd_power_of_a_ball_is_the_ball(n):
    assert_is_the_ball(f"{BALL}**{n}")


@pytest.mark.parametrize("formula", [f"{BALL}**3", f"-{BALL}**3*(-3)", f"{BALL}**3*(x - y)**2"])
def test_O6_an_odd_power_that_is_written_out_is_the_ball(formula):
    assert_is_the_ball(expanded(formula))


@pytest.mark.parametrize("factor", ["1e-300", "1e-154", "1e-20", "1e20", "1e153", "1e154", "1e300", "1.7e308"])
def test_O6_a_positive_factor_changes_nothing(factor):
    assert_is_the_ball(f"{BALL}*{factor}")
    assert_is_the_ball(f"{BALL}/{factor}")
    assert_is_the_ball("+".join(f"{factor}*{c}**2" for c in "xyz") + f"-{factor}")


def test_a_factor_beyond_the_range_of_doubles_changes_nothing():
    assert_is_the_ball(f"{BALL}*1e300*1e300")
    assert_is_the_ball(f"{BALL}*1e-300*1e-300")
    assert_is_the_ball(f"(1e100*{BALL})**5*1e200")


@pytest.mark.parametrize("factor", ["(x - y)**2", "(1 + z**2)", "exp(x)", "abs(x + y)", "(x**2 + y**2)"])
def test_factors_that_do_not_change_sign_change_nothing(factor):
    assert_is_the_ball(f"{BALL}**3*{factor}")


def test_a_ball_far_from_the_origin_of_its_formula_keeps_its_digits():
    """(x - 32)^2 + ... - 1, its cube written out: the form is about the ball's centre again."""
    far = "((x - 32)**2 + y**2 + z**2 - 1)"
    scene = lambda formula: make_scene(thing("expression", (-32, 0, 4), formula=formula), size=(24, 24))
    a, b = (render(scene(f)) for f in (expanded(f"{far}**3"), far))
    np.testing.assert_array_equal(a.index, b.index)
    np.testing.assert_allclose(a.t[b.index >= 0], b.t[b.index >= 0], rtol=1e-12)
    assert (a.status != UNDECIDED).all() and (a.index >= 0).any()


def test_paper_keeps_f_as_written():
    """Newton converges linearly at a root of multiplicity 5: after 20 iterations 0.8^20 of the first error is left."""
    ball, power = (picture(f, "paper") for f in (BALL, f"{BALL}**5"))
    hits = (ball.index == 0) & (power.index == 0)
    error = np.abs(power.t[hits] - ball.t[hits])
    assert hits.any() and np.median(error) > 1e-6


def test_the_product_of_two_balls_of_different_multiplicities():
    """q1 q2^3 is negative in one ball or the other, not in both; the same holds for its expansion."""
    other = "((x - 0.5)**2 + y**2 + z**2 - 0.5)"
    pictures = [picture(f, box={}) for f in (f"{BALL}*{other}", f"{BALL}*{other}**3", expanded(f"{BALL}*{other}**3"))]
    for p in pictures[1:]:
        np.testing.assert_array_equal(p.index, pictures[0].index)
        np.testing.assert_allclose(p.t[p.index >= 0], pictures[0].t[p.index >= 0], rtol=1e-12)


def test_shadows_of_odd_powers(n=5):
    """A ray that starts on the ball and leaves it casts no shadow on itself; through the ball it does."""
    scene = make_scene(thing("expression", formula=f"{BALL}**{n}", **BOX))
    d = np.random.default_rng(2).normal(size=(200, 3))
    d /= np.linalg.norm(d, axis=1)[:, None]
    assert (shine(scene, d, d, 10.0, inside=[False]) == 1).all()
    assert (shine(scene, d, -d, 10.0, inside=[False]) == 0).all()


# --- exact arithmetic --------------------------------------------------------------------------------------------------
@pytest.mark.parametrize("formula, degree", [(f"{BALL}**5", 10), (expanded(f"{BALL}**3"), 6), (f"{BALL}*1e300", 2),
                                             (f"{BALL}**2*z", 5)])
def test_exact_arithmetic_decides_by_f_as_written(formula, degree):
    """So that a wrong form would be found out: the reduction is judged, not assumed."""
    surface = Expression(formula=formula)
    g = ray_polynomial(surface, (0.1, 0.2, -4.0), (0.0, 0.0, 1.0)).p
    assert (g.degree() == degree and surface.degree < degree) or degree == 2
    line = follow(surface, (0.1, 0.2, -4.0), (0.0, 0.0, 1.0), bool(surface(0.1, 0.2, -4.0) < 0), 9.0)
    found = shoot(make_scene(thing("expression", formula=formula)), (0.1, 0.2, -4.0), (0, 0, 1))
    assert float(line.first) == pytest.approx(found.t[0], rel=1e-14)


def test_a_cube_that_is_not_algebraic_is_decided():
    scene = make_scene(thing("expression", PLACE, formula="(exp(x**2 + y**2 + z**2) - 2)**3*1e-200", **BOX), size=(32, 24))
    cube, ball = render(scene), picture("x**2 + y**2 + z**2 - log(2)", size=(32, 24))
    assert (cube.status != UNDECIDED).all()
    np.testing.assert_array_equal(cube.index == 0, ball.index == 0)
    line = follow(scene.objects[0].surface, (0.1, 0.2, -4.0), (0.0, 0.0, 1.0), False, 9.0)
    assert not line.undecided and float(line.first) == pytest.approx(4 - np.sqrt(np.log(2) - 0.05), rel=1e-14)


def test_the_scenes_of_formulas_that_are_one_solid():
    powers = (lambda c: f"abs({c})**2.5", lambda c: f"({c}*{c})**1.25", lambda c: f"(({c}/0.25)*({c}/0.25)/16)**1.25",
              lambda c: f"(-{c}*2*{c}*-2)**1.25/{4**1.25!r}", lambda c: f"sqrt({c}*{c}*{c}*{c})**1.25")
    box = {"bounds": {"low": [-1.1] * 3, "high": [1.1] * 3}}
    a, *others = (picture(f"{p('x')}+{p('y')}+{p('z')}-1", box=box) for p in powers)
    for b in others:
        np.testing.assert_array_equal(a.index, b.index)
        np.testing.assert_allclose(a.t[a.index >= 0], b.t[a.index >= 0], rtol=1e-13)
        assert (b.status != UNDECIDED).all() and (a.status != UNDECIDED).all()


@pytest.mark.parametrize("formula", [
    "max(x, 0)**2*(x**2 + y**2 + z**2 - 4)", "abs(max(x, 0))*(x**2 + y**2 + z**2 - 4)", "(abs(x) - x)**2*(y - 1)",
    "floor(x)**2*(x**2 + y**2 + z**2 - 4)", "(sqrt(x**2) + x)**2*(z - 1)", "smoothstep(0, 1, x)**2*(z - 1)",
    "(min(x, 0, y) + 0*z)**4*(z - 1)"])
def test_a_factor_that_is_zero_in_a_volume_is_no_factor_of_even_multiplicity(formula):
    """There f is zero: outside (O1). Where f is not zero its form has its sign, as always."""
    forms = forms_of(formula)
    zero = 0
    for point in np.random.default_rng(3).uniform(-1.5, 1.5, (200, 3)).tolist():
        f, form = forms.function(*point), forms.regular(*point, **forms.parameters)
        assert (f < 0) == (form < 0)
        zero += f == 0
    assert zero > 20


@pytest.mark.parametrize("formula", ["(abs(x) - 1)**2*(y - 1)", "(max(x, y) - 1)**2*(z - 1)", "(sqrt(x**2 + y**2) - 1)**2*(z - 1)",
                                     "(sin(x) - y)**2*(z - 1)", "abs(min(x, y + 1))*(z - 1)"])
def test_a_factor_whose_zeros_are_thin_is_dropped(formula):
    assert re.search(r" traced as \([yz]-", forms_of(formula).structure)
