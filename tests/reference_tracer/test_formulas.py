"""Formulas as trees: what is refused because it has no value anywhere, and formulas that differ in numbers share kernels."""

import math
import random
import warnings

import numpy as np
import pytest
from flint import arb
from tracing_support import make_scene, shoot, thing

from raytruth.reference_tracer.certify.line import follow
from raytruth.reference_tracer.certify.search import precision
from raytruth.reference_tracer.errors import InputError
from raytruth.reference_tracer.numbers import Dual, Interval, OutwardInterval
from raytruth.reference_tracer.numbers.exact import Series
from raytruth.reference_tracer.surfaces import Expression
from raytruth.reference_tracer.surfaces.expression import Bounds, forms_of
from raytruth.reference_tracer.surfaces.formula import FormulaError
from raytruth.reference_tracer.surfaces.formula_parser import parse_formula
from raytruth.reference_tracer.tracer.render import render

BOX = {"low": [-1.5] * 3, "high": [1.5] * 3}

# a formula without a value, the part of it that is to blame, and what is wrong with that
NO_VALUE = [
    ("x/0", "x/0", "divides by zero"), ("x*(y/0)", "y/0", "divides by zero"), ("x/(2-2)", "x/(2-2)", "divides by zero"),
    ("1 + x/2/(3*0)*y", "x/2/(3*0)*y", "divides by zero"), ("x/(y - y)", "x/(y - y)", "divides by zero"),
    ("z/((x+1)**2 - x**2 - 2*x - 1)", "z/((x+1)**2 - x**2 - 2*x - 1)", "divides by zero"),
    ("x**(1/0)", "1/0", "divides by zero"), ("0**-1*x", "0**-1", "divides by zero"),
    ("y*(x - x)**-2", "(x - x)**-2", "divides by zero"), ("x/(0*sin(y))", "x/(0*sin(y))", "divides by zero"),
    ("log(0) + x", "log(0)", "finite value"), ("sqrt(-1)+x", "sqrt(-1)", "finite value"),
    ("x + sqrt(2*3 - 7)", "sqrt(2*3 - 7)", "finite value"), ("log(x - x)*y", "log(x - x)", "no value"),
    ("sqrt(x - x - 1)+y", "sqrt(x - x - 1)", "no value"), ("(-8)**0.5+x", "(-8)**0.5", "negative number -8"),
    ("(-8)**x", "(-8)**x", "negative number -8"), ("(x - x - 1)**0.5 + y", "(x - x - 1)**0.5", "no value"),
    ("2e200*2e200*x", "2e200*2e200*x", "finite value"), ("exp(1000)*x", "exp(1000)", "finite value"),
    ("x + 1e200**2", "1e200**2", "finite value"), ("x + tan(1e308*10)", "1e308*10", "finite value")]


@pytest.mark.parametrize("formula, part, what", NO_VALUE)
def test_a_part_without_a_value_wherever_the_point_is_is_refused_and_named(formula, part, what):
    with pytest.raises(InputError) as error:
        make_scene(thing("expression", formula=formula))
    text = str(error.value)
    assert what in text and repr(part) in text and "objects[0].surface.formula" in text
    assert len(text.splitlines()) == 1


@pytest.mark.parametrize("formula, value", [
    ("x - x", "0"), ("0*x", "0"), ("0*sin(x)", "0"), ("x**0", "1"), ("-0.5 - y*0", "-0.5"), ("(x+1)**2 - x**2 - 2*x + 3", "4"),
    ("sqrt(z - z)", "0")])
def test_a_formula_with_one_value_everywhere_is_refused(formula, value):
    with pytest.raises(FormulaError, match=f"does not depend on x, y or z: it is {value} everywhere"):
        parse_formula(formula)


@pytest.mark.parametrize("formula, word", [("1e400*x", "too large"), ("x - 1e-400", "too small"),
                                           ("x + " + "9" * 400, "too large"), ("x - 1e-320", "too small"),
                                           ("x - 1e-200*1e-120", "too small")])
def test_numbers_that_doubles_do_not_hold_are_refused(formula, word):
    with pytest.raises(FormulaError, match=word):
        parse_formula(formula)
    assert parse_formula("x + 0e400 + 0.0 + 0 + 0x0")


def test_parameters_that_doubles_do_not_hold_are_refused():
    with pytest.raises(ValueError, match="k is a number too small for double precision"):
        Expression(formula="k*(4 - z)", parameters={"k": -1e-310})
    assert Expression(formula="k*(4 - z) + n", parameters={"k": 1e-300, "n": 0.0})


@pytest.mark.parametrize("formula", ["x/1e-300", "x/y", "log(x)", "0**x + y", "1/(x - y)", "x/(1 + x - x)", "2**x",
                                     "x + 1/3*0"])
def test_what_has_a_value_somewhere_is_no_error(formula):
    assert parse_formula(formula)


def test_long_sums_and_products_are_not_deep():
    text = "+".join(f"{k}*x" for k in range(1, 100))
    assert Expression(formula=text)(1.0, 0.0, 0.0) == sum(range(1, 100))
    assert Expression(formula="*".join(["x"] * 150))(1.01, 0.0, 0.0) == pytest.approx(1.01**150)


def test_random_text_is_a_formula_or_an_error():
    words = ["x", "y", "z", "1", "0", "2.5", "1e308", "1e-308", "+", "-", "*", "/", "**", "(", ")", ",", " ", "sqrt(", "max(",
             "log(", "pi", "abs(", "exp(", "lambda", "[", ":", "'", '"', "\\", "\n", "é", "\0", "if", "else", "^", "=", "ｘ",
             "¹", "0x", "_", "."]
    chance, read = random.Random(1), 0
    for _ in range(4000):
        text = "".join(chance.choices(words, k=chance.randrange(1, 14)))
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            try:
                forms_of(text)
                read += 1
            except FormulaError as error:
                assert str(error) and "\n" not in str(error)
    assert read > 20


# --- families ----------------------------------------------------------------------------------------------------------
KINDS = ["3 - x**2*{a} - {b}*y**2 - z**2*4", "min(x**2+y**2+z**2-{a}, max({b}, abs(x)+y**2+z**2-0.3))",
         "{a}/(1+x**2+y**2) - {b}*exp(z**2)", "x**4/{a}+y**4+z**4-{b}*x*y", "(x**2+y**2*{a}+z**2-{b})**3*2",
         "sqrt({a}+x**2)*sqrt(y**2+z**2+{b})-1", "log({a} + x**2+y**2+z**2)-{b}", "{a}-cbrt(x**2+y**2+{b}*z**2)",
         "1-({b}-x)*({a}-y)*z-2*x**2-2*y**2-z**2", "(x**2+{a}*y**2)**1.25 + z**2*{b} - 0.7"]


def members(kind: str, count: int, **bounds) -> list[dict]:
    return [thing("expression", (1.6 * (k % 5) - 3.2, 1.6 * (k // 5) - 3.0, 9.0), **bounds,
                  formula=kind.format(a=1 + k / 64, b=0.5 + k / 80)) for k in range(count)]


@pytest.mark.parametrize("method", ["exact", "paper"])
@pytest.mark.parametrize("kind", KINDS)
def test_formulas_of_one_family_are_traced_like_each_alone(kind, method):
    """Alone, the numbers of a formula are literals of the kernel; together they are read from a table."""
    things = members(kind, 3)
    scene = make_scene(*things, size=(40, 40))
    assert len({o.surface.family for o in scene.objects}) == 1
    together = render(scene, method)
    alone = [render(make_scene(one, size=(40, 40)), method) for one in things]
    t = np.min([np.where(p.index >= 0, p.t, np.inf) for p in alone], axis=0)
    np.testing.assert_allclose(np.where(together.index >= 0, together.t, np.inf), t, rtol=2e-14)
    assert np.isfinite(t).sum() > 20


@pytest.mark.parametrize("count", [3, 20])
def test_a_large_family_is_a_loop_and_shows_the_same(count):
    spheres = [thing("sphere", t["surface"]["center"], r=(0.5 + k / 80) ** 0.5) for k, t in enumerate(members("x", count))]
    balls = members("x**2 + y**2 + z**2 - {b}", count, bounds=BOX)
    a, b = (render(make_scene(*things, size=(40, 40))) for things in (spheres, balls))
    np.testing.assert_array_equal(a.index, b.index)
    np.testing.assert_allclose(a.t[a.index >= 0], b.t[a.index >= 0], rtol=1e-14)


def family(formula: str, bounded: bool = False) -> str:
    return Expression(formula=formula, bounds=Bounds(low=(-9.0,) * 3, high=(9.0,) * 3) if bounded else None).family


def test_numbers_are_no_part_of_a_family_but_exponents_and_structure_are():
    assert family("x**2 + 2*y - 1") == family("x**2 + 7.5*y - 1e-3")
    others = ["x**3 + 2*y - 1", "x**2 + y*2 - 1", "x**2 - 2*y - 1", "x**2 + 2*y + 1", "y**2 + 2*x - 1", "x**2 + 2*y",
              "x**2.5 + 2*y - 1", "x**2 + 2/y - 1", "sin(x)**2 + 2*y - 1", "cos(x)**2 + 2*y - 1", "x**2 + 2*(y - 1)"]
    assert len({family("x**2 + 2*y - 1"), *map(family, others)}) == 1 + len(others)
    assert family("x**1.5 + y") != family("x**2.5 + y")


def test_what_chooses_a_method_is_the_same_in_a_whole_family():
    for formula in ("x**2 + y**2 + z**2 - 1", "x**4 + y**2 + z**2 - 1", "exp(x**2 + y**2 + z**2) - 2"):
        assert family(formula) != family(formula, bounded=True)
    # a cone, a cylinder and a ball have one structure; a line may cross the first two once
    ball, cylinder, cone = (f"1*x**2 + 1*y**2 + {c}*z**2 - 1" for c in ("1", "0", "(-1)"))
    assert len({family(f, bounded=True) for f in (ball, cylinder, cone)}) >= 2
    assert family(ball, bounded=True) not in (family(cylinder, bounded=True), family(cone, bounded=True))
    # one that has lost its highest power is no quartic
    quartic, quadric, plane = "2*x**4 + y**2 + z - 1", "0*x**4 + y**2 + z - 1", "0*x**4 + 0*y**2 + z - 1"
    assert len({family(f.replace("+ y", "+ 1*y")) for f in (quartic, quadric, plane)}) == 3


@pytest.mark.parametrize("formula, plain, bounded", [
    ("0*x**2 + y", "y", False), ("x**2*0 + z - 0.5", "z - 0.5", False),
    ("x**4 - 1*x**4 + x**2 + y**2 + z**2 - 1", "x**2 + y**2 + z**2 - 1", False),
    ("(z + 1)**2 - z**2 + x", "2*z + 1 + x", False), ("0*x**3 + x**2 + y**2 - 1", "x**2 + y**2 - 1", False),
    ("x**2 - 1*x**2 + y", "y", False), ("0*x**4 + x**2 + y**2 + z**2 - 1", "x**2 + y**2 + z**2 - 1", True),
    ("x**2 + y**2 + z**2 - 1 + z**4*0", "x**2 + y**2 + z**2 - 1", True)])
def test_a_highest_power_that_cancels_is_none(formula, plain, bounded):
    box = {"bounds": {"low": [-1.5] * 3, "high": [1.5] * 3}} if bounded else {}
    # their relatives whose highest power does not cancel stand far behind, in the same scene
    other = formula.replace("0*", "0.5*").replace("*0", "*0.5").replace("1*", "3*")
    relative = thing("expression", (0, -2000, 900), formula=other, **box)
    a, b = (render(make_scene(thing("expression", (0, 0, 5), formula=f, **box), relative, size=(24, 24),
                              camera={"position": [0.1, 1.2, 0.0]}, max_distance=20.0)) for f in (formula, plain))
    np.testing.assert_array_equal(a.index, b.index)
    np.testing.assert_allclose(a.t[a.index >= 0], b.t[a.index >= 0], rtol=1e-13)
    assert (a.index == 0).any()


def test_a_quadric_that_is_no_ellipsoid_has_rays_that_meet_it_once():
    """Along (3, 0, 4) the cone x^2 + y^2 - (3/4 z)^2 is of degree one."""
    scene = make_scene(thing("expression", formula="x**2 + y**2 - 0.5625*z**2"))
    found = shoot(scene, (0.5, 0, 0), (3, 0, 4))
    assert found.index[0] == -1 or np.isfinite(found.t[0])
    inward = shoot(scene, (-0.5, 0, -2), (3, 0, 4))
    # |x| = 3/4 |z|: x = -0.5 + 0.6 t, z = -2 + 0.8 t give 0.25 - 0.6 t = 0.5625 (4 - 3.2 t), t = 1.6667
    assert inward.index[0] == 0 and inward.t[0] == pytest.approx((0.5625 * 4 - 0.25) / (0.5625 * 3.2 - 0.6), rel=1e-14)


def test_M7_a_ray_that_leaves_the_domain_of_f_is_undecided_unless_it_has_hit_before():
    """z - sqrt(1 - x^2 - y^2) has a value within the cylinder only. Written as a polynomial the same solid has one
    everywhere: it tells what the rays hit that do stay within the cylinder from the box on."""
    box = {"bounds": {"low": [-1.01] * 3, "high": [1.01] * 3}}
    domed, ball = (make_scene(thing("expression", formula=f"max({f}, -z)", **box))
                   for f in ("z - sqrt(1 - x**2 - y**2)", "x**2 + y**2 + z**2 - 1"))
    random = np.random.default_rng(4)
    o = np.stack([*random.uniform(-1.5, 1.5, (2, 4000)), np.where(random.random(4000) < 0.5, 3.0, -3.0)], axis=1)
    d = random.uniform(-1, 1, (4000, 3)) - o
    d /= np.linalg.norm(d, axis=1)[:, None]
    found, truth = shoot(domed, o, d, inside=[False]), shoot(ball, o, d, inside=[False])
    near, far = (np.array(corner)[:, None] for corner in ((-1.01,) * 3, (1.01,) * 3))
    slabs = np.stack([(near - o.T) / d.T, (far - o.T) / d.T])
    enters, leaves = slabs.min(axis=0).max(axis=0), slabs.max(axis=0).min(axis=0)
    # within the cylinder: |(x, y)|^2 - 1 = a t^2 + 2 b t + c < 0
    a, b, c = (d[:, :2]**2).sum(axis=1), (o[:, :2] * d[:, :2]).sum(axis=1), (o[:, :2]**2).sum(axis=1) - 1
    root = np.sqrt(np.maximum(b * b - a * c, 0))
    first, last = (-b - root) / a, (-b + root) / a
    end = np.minimum(truth.t, leaves)  # as far as f is asked for
    defined = (first < enters) & (end < last)
    meets = enters < leaves
    clear = np.minimum(np.abs(first - enters), np.abs(last - end)) > 1e-9
    np.testing.assert_array_equal(found.undecided[meets & clear], ~defined[meets & clear])
    assert not found.undecided[~meets].any()
    np.testing.assert_array_equal(found.index[~found.undecided], truth.index[~found.undecided])
    hits = ~found.undecided & (found.index == 0)
    np.testing.assert_allclose(found.t[hits], truth.t[hits], rtol=1e-13)
    assert hits.sum() > 100 and found.undecided.sum() > 100


def test_a_ray_that_ends_outside_the_domain_of_f_is_undecided_for_that_reason():
    dome = Expression(formula="max(z - sqrt(1 - x**2 - y**2), -z)")
    assert follow(dome, (0.1, 0.2, 3.0), (0.5, 0.0, -1.0), False, 9.0).undecided == "f is not finite along the ray"
    assert not follow(dome, (0.1, 0.2, 3.0), (0.0, 0.0, -1.0), False, 9.0).undecided


def test_equal_factors_are_a_square_for_every_number_type():
    """sqrt((x - c)**2 + ...) is defined everywhere, however the square is written."""
    f = forms_of("sqrt((x - 0.3)*(x - 0.3) + y*y + z*z) - 1")
    value = f.regular(*(OutwardInterval(-2.0, 2.0) for _ in range(3)), **f.parameters)
    assert value.low <= -1 and -1.001 < value.low and value.high == pytest.approx(math.sqrt(2.3**2 + 8) - 1)
    assert family("(x - 1)*(x - 1) - y") != family("(x - 1)*(x - 2) - y")


@pytest.mark.parametrize("square", [
    "x*x*y*y", "x*y*x*y", "x/3*(x/3)", "(x/3)*(x/3)*y*y", "(x*x)*y*y", "-x*-x*y**2", "-x*(-x)", "-(-x*x)", "-2*x*(x/-3)",
    "x*(y*y + z*z)*x", "x*y**3*(x*y)", "x*exp(y)*x", "x/y*(y*x)", "cbrt(x)*x", "x*abs(y)/7*x"])
def test_a_product_of_pairs_is_not_negative_however_it_is_written(square):
    """Its root and its real powers are defined wherever it is; interval arithmetic alone sees factors of both signs."""
    for number in (OutwardInterval, Interval):
        point = number(-2.0, 2.0), number(0.2), number(-0.3)
        for form in (f"sqrt({square}) + 0*x", f"({square})**1.3 - 1"):
            f, thin = forms_of(form), forms_of(form).function(1.5, 0.2, -0.3)
            value = number.of(f.function(*point, **f.parameters))
            assert -1.1 < value.low <= thin <= value.high < 20
            slope = f.function(*Dual.along(point, (1.0, 0.0, 0.0)), **f.parameters).value
            assert slope.low <= thin <= slope.high
    with precision(96):
        ball = forms_of(f"({square})**1.3").function(*Series.along((0, 0.2, -0.3), (1, 0, 0), arb(0, 2)))
        assert ball.s[0].contains(arb(forms_of(f"({square})**1.3").function(1.5, 0.2, -0.3))) and ball.nonnegative


@pytest.mark.parametrize("product", [
    "x*x*x", "-x*x", "x*y*x", "x/3*(x/-3)", "-2*x*(x*3)", "x*log(x)*x", "-(x*x)", "x*x*(x + 1)"])
def test_a_product_that_may_be_negative_has_no_root(product):
    f = forms_of(f"sqrt({product}) + 0*x")
    value = f.function(OutwardInterval(-2.0, 2.0), OutwardInterval(-1.0), OutwardInterval(1.0), **f.parameters)
    assert math.isnan(value.low) and math.isnan(value.high)


def test_sixty_baked_balls_are_one_family_and_what_spheres_show():
    """Sixty formulas that hold their own places and sizes, each with bounds of its own: one kernel, the spheres' picture."""
    chance = np.random.default_rng(60)
    centers, radii = chance.uniform((-3, -2, 6), (3, 2, 12), (60, 3)), chance.uniform(0.2, 0.5, 60)
    baked = [thing("expression", formula="+".join(f"({v}-({c!r}))**2" for v, c in zip("xyz", p.tolist())) + f"-{float(r * r)!r}",
                   bounds={"low": (p - 1.01 * r).tolist(), "high": (p + 1.01 * r).tolist()}) for p, r in zip(centers, radii)]
    scene = make_scene(*baked, size=(64, 48))
    assert len({o.surface.family for o in scene.objects}) == 1
    a, b = render(scene), render(make_scene(*(thing("sphere", tuple(p.tolist()), r=float(r)) for p, r in zip(centers, radii)),
                                            size=(64, 48)))
    np.testing.assert_array_equal(a.index, b.index)
    np.testing.assert_allclose(a.t[b.index >= 0], b.t[b.index >= 0], rtol=1e-13)


def test_a_solid_of_revolution_is_right_but_for_its_axis():
    """A Reuleaux triangle turned about z: three arcs of radius sqrt(3) about its corners; no gradient on the axis."""
    arcs = ["(sqrt(x**2+y**2)-0)**2+(z-1)**2-3", f"(sqrt(x**2+y**2)-{0.75**0.5!r})**2+(z+0.5)**2-3",
            f"(sqrt(x**2+y**2)+{0.75**0.5!r})**2+(z+0.5)**2-3"]
    box = {"low": [-1.5] * 3, "high": [1.5] * 3}
    solid = thing("expression", (0, 0, 6), formula=f"max({arcs[0]}, max({arcs[1]}, {arcs[2]}))", bounds=box)
    picture = render(make_scene(solid, size=(41, 31)))
    assert np.argwhere(picture.status == 2).tolist() == [[15, 20]]  # the ray along the axis
    met = picture.index >= 0
    x, y, z = np.moveaxis(picture.position[met] - (0, 0, 6), -1, 0)
    rho = np.hypot(x, y)
    corners = np.array([(0, 1), (0.75**0.5, -0.5), (-(0.75**0.5), -0.5)])
    farthest = np.max([np.hypot(rho - a, z - b) for a, b in corners], axis=0)
    np.testing.assert_allclose(farthest, 3**0.5, rtol=1e-14)
    assert met.sum() > 80
