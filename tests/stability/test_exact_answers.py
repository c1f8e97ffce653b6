"""The exact answers against python-flint's certified roots, closed forms and simulations of their own."""

import math

import numpy as np
import pytest
from flint import arb, ctx, fmpq, fmpq_poly

from raytruth.comparisons.stability import cases as families
from raytruth.comparisons.stability.exact import ball_crossings, crossings, rational, root_between
from raytruth.comparisons.stability.families.root_set import PROBLEMS
from raytruth.comparisons.stability.family import Draw


def _certified(coefficients) -> list[tuple[arb, int]]:
    """The real roots of a rational polynomial with their multiplicities, ascending."""
    with ctx.workprec(200):
        roots = fmpq_poly(coefficients).numer().complex_roots()
        return sorted(((r.real, m) for r, m in roots if r.imag == 0), key=lambda root: float(root[0]))


@pytest.mark.parametrize("impact", [0.5, 1 - 1e-8, 1 - 1e-15, 1 - 1e-16, 1 + 1e-15, 1 + 1e-3])
def test_crossings_of_a_ball(impact):
    """Coefficients of |o + t d - c|^2 - r^2 multiplied out by hand in fractions, roots isolated by flint."""
    draw = Draw(60, np.random.default_rng(1), 64)
    o, d = draw.lines(np.full(60, impact), 3.0, jitter=0.3)
    o[:, 0] += 7.25
    found = ball_crossings(o, d, [7.25] * 60, [fmpq(1)] * 60)
    for i in range(60):
        x = [rational(v) - shift for v, shift in zip(o[i], (fmpq(29, 4), 0, 0))]
        v = [rational(w) for w in d[i]]
        dot = lambda a, b: sum((p * q for p, q in zip(a, b)), fmpq(0))
        simple = [float(t) for t, m in _certified([dot(x, x) - 1, 2 * dot(x, v), dot(v, v)]) if m == 1]
        assert found[i].tolist() == (simple or [math.inf, math.inf])


def test_a_line_that_touches_does_not_cross():
    """Exactly tangent in floats: y = 1 along x past the unit sphere (M1); one unit in the last place closer crosses."""
    ones = [fmpq(1)]
    assert np.isinf(ball_crossings(np.array([[-3.0, 1, 0]]), np.array([[1.0, 0, 0]]), [0.0], ones)).all()
    inner = np.array([[-3.0, np.nextafter(1, 0), 0]])
    assert np.isfinite(ball_crossings(inner, np.array([[1.0, 0, 0]]), [0.0], ones)).all()


@pytest.mark.parametrize("name", ["heart-belt", "heart-tips"])
def test_first_hits_of_the_heart_are_changes_of_sign(name):
    """In rational arithmetic f changes sign within 1e-14 of the stated t, and at none of 200 points before it."""
    family, = families.find([name])
    f = family.shape.f
    for rays in family.cases(64, 8):
        for o, d, first in zip(rays.o, rays.d, rays.first):
            value = lambda t: f(*(_Exact(rational(a) + rational(b) * rational(t)) for a, b in zip(o, d))).q
            if np.isfinite(first):
                assert value(first - 1e-14) > 0 > value(first + 1e-14)
            end = min(first, 6.0) * (1 - 1e-9)
            assert all(value(t) > 0 for t in np.linspace(0, end, 200))


class _Exact:
    """A rational number that f of the heart can be evaluated on; floats are taken exactly."""

    def __init__(self, q):
        self.q = q

    def _binary(operate):
        return lambda self, other: _Exact(operate(self.q, other.q if isinstance(other, _Exact) else rational(other)))

    __add__, __sub__ = _binary(lambda a, b: a + b), _binary(lambda a, b: a - b)
    __mul__, __truediv__ = _binary(lambda a, b: a * b), _binary(lambda a, b: a / b)

    def __pow__(self, n):
        return _Exact(self.q**n)


def test_the_thin_shell_in_rational_arithmetic():
    """The sextic-free case: (q - p)(q + p) multiplied out has the stated first root."""
    family, = families.find(["thin-shell"])
    for rays, p in zip(family.cases(64, 6), family.about.values):
        f = lambda x, y, z: ((x**2 + y**2 + z**2 - 1) - p) * ((x**2 + y**2 + z**2 - 1) + p)
        for o, d, first in zip(rays.o, rays.d, rays.first):
            assert crossings(f, o, d, 6.0)[0] == pytest.approx(first, rel=1e-15)


# --- the root set --------------------------------------------------------------------------------------------------
KNOWN = {  # number of the problem: its root in closed form
    3: lambda c: 0.0, 4: lambda c: c["a"] ** (1 / 12), 5: lambda c: math.pi / 6,
    7: lambda c: _smaller_root(c["n"] ** 2, -(2 * c["n"] + 1 + (1 - c["n"]) ** 2), 1.0),
    11: lambda c: 1 / c["n"], 12: lambda c: c["n"], 13: lambda c: 0.0,
    15: lambda c: 2 * math.log(1.859) / (1000 * (c["n"] + 1))}


def _smaller_root(a, b, c):
    return 2 * c / (-b + math.sqrt(b * b - 4 * a * c))


@pytest.mark.parametrize("number", KNOWN)
def test_roots_known_in_closed_form(number):
    problem = PROBLEMS[number - 1]
    for choice in problem.choices:
        assert problem.root(choice) == pytest.approx(KNOWN[number](choice), rel=2e-15, abs=1e-12)


def test_the_first_problem_of_the_paper():
    """sin x = x/2: Newton's iteration in 100-digit balls, from 1.9, ends at the same double."""
    with ctx.workprec(350):
        x = arb("1.9")
        for _ in range(12):
            x = (x - (x.sin() - x / 2) / (x.cos() - arb(1) / 2)).mid()
        assert PROBLEMS[0].root({}) == float(x)


@pytest.mark.parametrize("number", range(1, len(PROBLEMS) + 1))
def test_every_problem_has_one_root_in_its_interval(number):
    """f as NumPy sees it has opposite signs on both sides of the root, and no other change of sign on 2000 points."""
    problem = PROBLEMS[number - 1]
    for choice in problem.choices:
        (a, b), root = problem.interval(**choice), problem.root(choice)
        x = np.concatenate([np.linspace(a, root, 1000)[:-1], np.linspace(root, b, 1000)[1:]])
        with np.errstate(all="ignore"):
            value = problem.f(x, **problem.parameters(choice))
        signs = np.sign(value)
        if number == 13:  # zero to all digits around its root
            assert (signs == 0).sum() > 10
            x, signs = x[signs != 0], signs[signs != 0]
        assert np.all(signs[x < root] == signs[0]) and np.all(signs[x > root] == -signs[0])


def test_no_root_is_invented():
    with pytest.raises(ValueError):
        root_between(lambda x: x * x + 1, -1.0, 1.0)
    with pytest.raises(ValueError):
        root_between(lambda x: x * x, -1.0, 1.0)


# --- the whole model -----------------------------------------------------------------------------------------------
def test_the_mirror_box_against_reflections_one_by_one():
    """The unfolded sum against a ball that bounces: the next wall is the smallest (sign - x)/d, then d flips there."""
    family, = families.find(["mirror-box"])
    light = np.array([0.3, 0.4, -0.2])
    for case, reflections in zip(family.cases(64, 40), family.about.values):
        for o, d, value in zip(case.o, case.d, case.truth["value"]):
            x, v, total = o.copy(), d.copy(), 0.0
            for k in range(int(reflections) + 1):
                t = (np.sign(v) - x) / v
                axis = int(np.argmin(t))
                x, side = x + t[axis] * v, np.sign(v[axis])
                to_light = light - x
                total += 0.9**k * 0.1 * abs(to_light[axis]) / np.linalg.norm(to_light)
                x[axis], v[axis] = side, -v[axis]
            assert value == pytest.approx(total, abs=1e-11)


def test_the_slab_stack_against_snell_in_the_plane():
    """Distance along the slabs summed face by face with sin(phi) / index, in the plane of incidence."""
    family, = families.find(["slab-stack"])
    normal = np.array([1, 2, 2]) / 3
    for case in family.cases(64, 20):
        for o, d, end in zip(case.o, case.d, case.truth["point"]):
            height, shift, sine = o @ normal, 0.0, np.linalg.norm(np.cross(d, normal))
            for top in (0.0, -0.2, -0.4, -0.6):
                shift += (height - top) * sine / -(d @ normal)
                shift += 0.1 * (sine / 1.5) / math.sqrt(1 - (sine / 1.5) ** 2)
                height = top - 0.1
            assert end @ normal == pytest.approx(height, abs=1e-13)
            across = d - (d @ normal) * normal
            assert (end - o) @ across / np.linalg.norm(across) == pytest.approx(shift, rel=1e-12)
