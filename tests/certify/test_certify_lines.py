"""What an exact ray does with one object, against cases made by hand."""

import math

import numpy as np
import pytest
from flint import arb, ctx

from raytruth.reference_tracer.certify.line import follow, ray_polynomial
from raytruth.reference_tracer.certify.origins import starts_along, starts_on
from raytruth.reference_tracer.certify.reasons import why
from raytruth.reference_tracer.surfaces.expression import Expression
from raytruth.reference_tracer.surfaces.heart import Heart
from raytruth.reference_tracer.surfaces.sphere import Sphere
from raytruth.reference_tracer.surfaces.torus import Torus

UP = (0.0, 0.0, 1.0)
BELOW, ABOVE = math.nextafter(1, 0), math.nextafter(1, 2)
BALLS = {"sphere": Sphere(r=1.0), "expression": Expression(formula="sqrt(x**2 + y**2 + z**2) - 1")}


def _at(line) -> list[float]:
    assert not line.undecided
    return [float(t) for t in line.crossings]


def test_a_chord_is_found_exactly():
    """r = 5, impact parameter 3: half a chord is 4."""
    line = follow(Sphere(r=5.0), (3.0, 0.0, -10.0), UP, False, 30.0)
    assert line.crossings == [arb(6), arb(14)] and not line.touches and not line.wrong_start


def test_a_tangent_ray_touches_and_its_neighbours_do_not():
    """One unit in the last place of the impact parameter decides; half the inner chord is sqrt(1 - b^2)."""
    touching, inner, outer = (follow(BALLS["sphere"], (b, 0.0, -3.0), UP, False, 30.0) for b in (1.0, BELOW, ABOVE))
    assert not touching.crossings and touching.touches == [arb(3)]
    half = math.sqrt(2 * 2.0**-53)  # 1 - b^2 = 2 (1 - b) to first order
    assert _at(inner) == pytest.approx([3 - half, 3 + half], rel=1e-14) and not inner.touches
    assert not outer.crossings and not outer.touches


def test_even_roots_are_touched_and_odd_ones_crossed():
    square, cube = (Expression(formula=f"(x**2 + y**2 + z**2 - 1)**{n}") for n in (2, 3))
    touched, crossed = (follow(s, (0.0, 0.0, -3.0), UP, False, 30.0) for s in (square, cube))
    assert not touched.crossings and touched.touches == [arb(2), arb(4)]
    assert crossed.crossings == crossed.multiple == [arb(2), arb(4)]


def test_a_torus_along_its_axes():
    """R = 2, r = 1/2: along x four crossings; along z through the hole none; along x at height 1/2 two touches."""
    ring = Torus(R=2.0, r=0.5)
    x = (1.0, 0.0, 0.0)
    assert _at(follow(ring, (-10.0, 0.0, 0.0), x, False, 30.0)) == [7.5, 8.5, 11.5, 12.5]
    assert _at(follow(ring, (0.0, 0.0, -10.0), UP, False, 30.0)) == []
    top = follow(ring, (-10.0, 0.0, 0.5), x, False, 30.0)
    assert not top.crossings and [float(t) for t in top.touches] == [8, 12]
    assert len(follow(ring, (-10.0, 0.0, math.nextafter(0.5, 0)), x, False, 30.0).crossings) == 4
    spindle = Torus(R=0.5, r=0.75)  # no inner sheet: off the axis by 0.1 the ray crosses at +- sqrt(r^2 - 0.4^2)
    half = math.sqrt(0.75**2 - 0.4**2)
    line = follow(spindle, (0.1, 0.0, -3.0), UP, False, 30.0)
    assert _at(line) == pytest.approx([3 - half, 3 + half], rel=1e-15)


def test_the_hearts_singular_ellipse_is_crossed_at_triple_roots():
    """In y = 0 the printed f is (x^2 + 9/4 z^2 - 1)^3."""
    line = follow(Heart(), (-3.0, 0.0, 0.0), (1.0, 0.0, 0.0), False, 30.0)
    assert line.crossings == line.multiple == [arb(2), arb(4)]
    line = follow(Heart(), (0.0, 0.0, -3.0), UP, False, 30.0)
    assert _at(line) == pytest.approx([3 - 2 / 3, 3 + 2 / 3], rel=1e-15) and len(line.multiple) == 2


@pytest.mark.parametrize("ball", BALLS.values(), ids=BALLS)
@pytest.mark.parametrize("z, direction, inside, expected, wrong", [
    (-1.0, 1, True, [2], False),  # enters from the surface: runs through the ball
    (-1.0, -1, False, [], False),  # reflected away
    (-1.0, 1, False, [0, 2], True),  # known outside, yet heads inside at once: crosses as it starts
    (-1 - 2**-40, 1, True, [2 + 2**-40], True),  # entered, its origin rounded outwards: that crossing is behind it
    (-1 + 2**-40, -1, False, [], True),  # reflected, its origin rounded inwards
    (-1 + 2**-40, 1, False, [0, 2 - 2**-40], True)])
def test_a_ray_that_starts_on_the_surface_goes_by_the_side_it_is_known_to_be_on(ball, z, direction, inside, expected,
                                                                               wrong):
    line = follow(ball, (0.0, 0.0, z), (0.0, 0.0, float(direction)), inside, 30.0)
    assert _at(line) == pytest.approx(expected, abs=1e-17, rel=1e-15) and line.wrong_start == wrong


def test_the_ray_ends_at_its_limit():
    ball = BALLS["sphere"]
    for limit, expected in ((1.5, []), (2.0, [2]), (2.5, [2]), (5.0, [2, 4])):
        assert _at(follow(ball, (0.0, 0.0, -3.0), UP, False, limit)) == expected


def test_balls_find_what_exact_roots_find():
    """The unit ball as polynomial and through sqrt, 60 random rays: the same crossings to 1e-24."""
    random = np.random.default_rng(3)
    crossed = 0
    for _ in range(60):
        o = random.normal(size=3) * 2
        d = random.uniform(-1, 1, 3) - o
        inside = bool(o @ o < 1)
        exact, balls = (follow(ball, o, d / np.linalg.norm(d), inside, 30.0) for ball in BALLS.values())
        assert len(exact.crossings) == len(balls.crossings) and not balls.undecided
        with ctx.workprec(192):
            assert all(abs(a - b) < arb(1e-24) for a, b in zip(exact.crossings, balls.crossings))
        crossed += len(exact.crossings)
    assert crossed > 60


def test_transcendental_surfaces_are_decided_front_to_back():
    """sin(pi-ish z) along z: crossings at the multiples of pi, all of them or the first."""
    waves = Expression(formula="sin(z) + 0*x")
    every = follow(waves, (0.0, 0.0, 1.0), UP, False, 12.0)
    assert _at(every) == pytest.approx([k * math.pi - 1 for k in (1, 2, 3, 4)])
    first = follow(waves, (0.0, 0.0, 1.0), UP, False, 12.0, only_first=True)
    assert _at(first) == pytest.approx([math.pi - 1])
    solid = Expression(formula="0 - sin(z) + 0*x", inside="positive")  # the same solid, its sign flipped
    assert _at(follow(solid, (0.0, 0.0, 1.0), UP, False, 4.0)) == pytest.approx([math.pi - 1])


@pytest.mark.parametrize("formula, o, reason", [
    ("sqrt(x**2 + y**2 + z**2) - 1", (1.0, 0.0, -3.0), "near a touching point"),
    ("1/z", (0.1, 0.2, -3.0), "f is not finite along the ray"),
    ("sqrt(z) - 0.5", (0.1, 0.2, -3.0), "f is not finite along the ray"),
    ("x**2 + y", (0.0, 0.0, -3.0), "the ray lies within the surface")])
def test_what_cannot_be_told_is_said_to_be_undecided(formula, o, reason):
    line = follow(Expression(formula=formula), o, UP, False, 8.0)
    assert line.undecided == reason and not line.crossings


def test_reasons_name_what_is_special_about_a_ray():
    ball = BALLS["sphere"]
    told = lambda b: why(ball, (b, 0.0, -3.0), UP, follow(ball, (b, 0.0, -3.0), UP, False, 30.0), 30.0)
    assert told(1.0) == "touches without crossing"
    assert told(BELOW) == "two crossings closer than 1e-6"
    assert told(ABOVE) == "passes within rounding of touching"
    assert told(0.5) == "rounding hides the sign of f"
    triple = follow(Heart(), (-3.0, 0.0, 0.0), (1.0, 0.0, 0.0), False, 30.0)
    assert why(Heart(), (-3.0, 0.0, 0.0), (1.0, 0.0, 0.0), triple, 30.0) == "crosses at a multiple root"


def test_where_a_ray_starts_is_told_by_enclosures_of_any_f():
    """Distances are those of the ball, whatever its gradient does: it vanishes on the cube, is infinite on the root."""
    for formula, excluded in (("{}", 0.99), ("({})**3", 0.99), ("cbrt({})", 0.99),
                              ("sqrt(x**2 + y**2 + z**2) - 1 + 0*{}", 0.99)):
        ball = Expression(formula=formula.format("(x**2 + y**2 + z**2 - 1)"))
        for distance in (2.0**-50, -(2.0**-30)):
            o = (1 + distance, 0.0, 0.0)
            assert starts_on(ball, o, 1.01 * abs(distance)) and not starts_on(ball, o, excluded * abs(distance))
        assert starts_on(ball, (5.0, 0.0, 0.0), math.inf)
    ball = BALLS["sphere"]
    assert starts_along(ball, (1.0, 0.0, 0.0), (-1e-14, 0.0, 1.0))
    assert not starts_along(ball, (1.0, 0.0, 0.0), (1e-9, 0.0, 1.0))
    cube = Expression(formula="(x**2 + y**2 + z**2 - 1)**3")
    assert starts_along(cube, (1.0, 0.0, 0.0), UP) and not starts_along(cube, (1.0, 0.0, 0.0), (0.6, 0.0, 0.8))


@pytest.mark.parametrize("ball", BALLS.values(), ids=BALLS)
def test_a_ray_from_the_wrong_side_that_never_comes_back_is_undecided(ball):
    """Known inside, outside by 2^-40, and heading in so flatly that it passes by."""
    line = follow(ball, (1 + 2.0**-40, 0.0, 0.0), (-(2.0**-42), 0.0, 1.0), True, 30.0)
    assert line.undecided == "starts on the wrong side of the surface and does not come back" and line.wrong_start


def test_f_is_decided_as_it_is_written_where_that_is_a_polynomial():
    torus, power = Torus(R=2.0, r=0.5), Expression(formula="(x**2 + y**2 + z**2 - 1)**5")
    assert power.exact_form is power.function and torus.exact_form is torus.polynomial_form
    assert Expression(formula="sin(x) + y").exact_form is None
    assert ray_polynomial(power, (0.0, 0.0, -3.0), UP).p.degree() == 10
