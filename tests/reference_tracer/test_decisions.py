"""The rows of DECISIONS.md about rays (M1 to M7, N1, R4), and that every row of it has a test that carries its id."""

import ast
import re
from importlib.resources import files
from pathlib import Path

import numpy as np
import pytest
from tracing_support import follow, make_scene, shine, shoot, thing, unit

from raytruth import reference_tracer
from raytruth.reference_tracer.first_hit import METHODS
from raytruth.reference_tracer.tracer.render import UNDECIDED, render

FORWARD = (0, 0, 1)
TRUTHS = ("paper", "exact")
BASIC = (*TRUTHS, "interval")


def formula(text: str, **rest) -> dict:
    return thing("expression", formula=text, **rest)


def test_every_decision_has_a_test_that_carries_its_id():
    rows = re.findall(r"^\| ([A-Z]\d+) \|", files(reference_tracer).joinpath("DECISIONS.md").read_text("utf-8"),
                      re.MULTILINE)
    assert len(rows) == len(set(rows)) >= 27
    functions = [node.name for path in Path(__file__).parent.glob("test_*.py")
                 for node in ast.walk(ast.parse(path.read_text("utf-8"))) if isinstance(node, ast.FunctionDef)]
    tested = {match[1] for name in functions if (match := re.match(r"test_([A-Z]\d+)_", name))}
    assert set(rows) == tested


# --- M1 ------------------------------------------------------------------------------------------------------------
@pytest.mark.parametrize("method", METHODS)
def test_M1_a_ray_that_only_touches_has_not_hit(method):
    """(z - 2)^2 is zero at 2 and positive elsewhere; the ray along z touches the ball about (1, 0, 2). h = 0.5 puts a
    sample exactly on the zero. Behind both stands a plane that is crossed."""
    wall = thing("plane", (0, 0, 5), a=0, b=0, c=-1)
    for touched in (formula("(z - 2)**2"), thing("sphere", (1, 0, 2), r=1)):
        found = shoot(make_scene(touched, wall, step_size=0.5), (0, 0, 0), FORWARD, method)
        if method == "descartes" and found.undecided[0]:
            continue  # a double root is what its rule cannot tell, and it says so
        assert found.index.tolist() == [1] and found.t == pytest.approx(5, rel=1e-15)
        assert shine(make_scene(touched, step_size=0.5), (0, 0, 0), FORWARD, 4.0, method).tolist() == [1]


# --- M2 ------------------------------------------------------------------------------------------------------------
def test_M2_samples_lie_at_multiples_of_the_step_counted_from_one():
    """h = 1. Balls of radius 0.1 about 1, 2, 3 hold a sample, those about 0 (only its far half lies ahead), 0.5, 1.5,
    2.5 hold none. The ray starts outside of all of them, by decree where it starts within the one about 0."""
    for center in (0.0, 0.5, 1.0, 1.5, 2.0, 2.5, 3.0):
        scene = make_scene(thing("sphere", (0, 0, center), r=0.1), step_size=1)
        found = shoot(scene, (0, 0, 0), FORWARD, "paper", inside=[[False]])
        assert (found.index[0] == 0) == (center in (1.0, 2.0, 3.0)), center


@pytest.mark.parametrize("method", BASIC)
def test_M2_the_side_at_the_start_is_told_and_not_read_off_f(method):
    """Rays start on a unit ball, with f at the start a rounding error of either sign. Told to be outside they run away
    without a hit; told to be inside they leave through the far side, 2 |d . n| on."""
    normal = unit(np.random.default_rng(1).normal(size=(300, 3)))
    scene = make_scene(thing("sphere", r=1), step_size=0.01)
    noise = np.sum(normal**2, axis=1) - 1
    assert (noise < 0).any() and (noise > 0).any()
    outward = unit(normal + 0.9 * unit(np.random.default_rng(2).normal(size=(300, 3))))
    away = shoot(scene, normal, outward, method, inside=[[False]])
    assert np.all(away.index == -1)
    through = shoot(scene, normal, -outward, method, inside=[[True]])
    np.testing.assert_allclose(through.t, 2 * np.sum(normal * outward, axis=1), rtol=1e-11)


def test_M2_the_last_step_is_shortened_to_the_end_of_the_ray():
    """h = 0.7, range 30: the last samples are 29.4 and 30, not 30.1. A plane at 29.9 is seen, one at 30.05 not."""
    for z, index in ((29.9, 0), (30.05, -1)):
        scene = make_scene(thing("plane", (0, 0, z), a=0, b=0, c=-1), step_size=0.7)
        assert shoot(scene, (0, 0, 0), FORWARD, "paper").index.tolist() == [index]


# --- M3 ------------------------------------------------------------------------------------------------------------
@pytest.mark.parametrize("method", TRUTHS)
def test_M3_a_camera_ray_starts_with_the_sign_of_f_at_the_camera(method):
    """The camera stands in the first ball and outside of the second: it meets the first one's far wall at 3."""
    scene = make_scene(thing("sphere", (0, 0, 1), r=2), thing("sphere", (0, 0, 6), r=1))
    picture = render(scene, method)
    assert picture.index.tolist() == [[0]] and picture.t == pytest.approx(3, rel=1e-14)


@pytest.mark.parametrize("method", TRUTHS)
def test_M3_sides_are_inherited_by_reflection_and_flipped_by_refraction_of_that_object_alone(method):
    """Three glass balls (n = 1), one in another and one apart, seen along their common diameter: from the camera in the
    outermost ball to the last exit the ray meets 2, 3, 5, 7, 9 and nothing it should not."""
    glass = {"transparency": 1, "refractive_index": 1}
    balls = [thing("sphere", (0, 0, 1), r=4, material=glass), thing("sphere", (0, 0, 2.5), r=0.5, material=glass),
             thing("sphere", (0, 0, 8), r=1, material=glass)]
    generations = follow(make_scene(*balls, background=(1, 1, 1)), method)
    np.testing.assert_allclose(np.concatenate([g.o for g in generations])[:, 2], [0, 2, 3, 5, 7, 9], atol=1e-13)
    # a mirror within the outermost ball: the reflection is still in that ball and leaves it at -3
    mirror = thing("sphere", (0, 0, 3), r=1, material={"reflection": 1})
    generations = follow(make_scene(balls[0], mirror), method)
    np.testing.assert_allclose(np.concatenate([g.o for g in generations])[:, 2], [0, 2, -3], atol=1e-13)


@pytest.mark.parametrize("method", TRUTHS)
def test_M3_nothing_is_offset_by_an_epsilon(method):
    """A glass ball (n = 1) of radius 1e-5 and a mirror 1e-9 behind a glass plane: both lie within any usual epsilon."""
    glass = {"transparency": 1, "refractive_index": 1}
    tiny = make_scene(thing("sphere", (0, 0, 0.05), r=1e-5, material=glass), step_size=1e-5, max_distance=1)
    np.testing.assert_allclose([g.o[0, 2] for g in follow(tiny, method)], [0, 0.05 - 1e-5, 0.05 + 1e-5], rtol=1e-12)
    pane = thing("plane", (0, 0, 1), a=0, b=0, c=-1, material=glass)
    mirror = thing("plane", (0, 0, 1 + 1e-9), a=0, b=0, c=-1, material={"reflection": 1})
    generations = follow(make_scene(pane, mirror), method)
    np.testing.assert_allclose([g.o[0, 2] for g in generations], [0, 1, 1 + 1e-9, 1], rtol=1e-14)
    assert [g.d[0, 2] for g in generations] == [1, 1, -1, -1]


# --- M4, M5 --------------------------------------------------------------------------------------------------------
@pytest.mark.parametrize("order", [(0, 1), (1, 0)])
@pytest.mark.parametrize("kind", ["sphere", "expression"])
def test_M4_of_several_changes_in_one_step_the_nearest_counts(kind, order):
    """h = 1: walls at 2.8 and 2.3, both met in the step from 2 to 3, in either order of the scene and whether or not
    they share a kernel's loop."""
    make = {"sphere": lambda z: thing("sphere", (0, 0, z + 5), r=5), "expression": lambda z: formula(f"{z} - z")}[kind]
    walls = [make(2.8), thing("sphere", (0, 0, 7.3), r=5)]
    scene = make_scene(*(walls[k] for k in order), step_size=1)
    found = shoot(scene, (0, 0, 0), FORWARD, "paper")
    assert found.t == pytest.approx(2.3, rel=1e-12) and found.index.tolist() == [order.index(1)]


@pytest.mark.parametrize("method", TRUTHS)
def test_M5_every_ray_ends_at_max_distance_counted_anew(method):
    """Mirror at 20, wall 25 behind it: direct rays see up to 30, the reflection may travel another 25 + 20 = 45 > 30.
    With max_distance = 50 both are met. The wall is lit from its front."""
    mirror = thing("plane", (0, 0, 20), a=0, b=0, c=-1, material={"reflection": 1})
    wall = thing("plane", (0, 0, -5), a=0, b=0, c=1)
    for far, seen in (({}, 1), ({"max_distance": 24.9}, 0), ({"max_distance": 19.9}, 0)):
        color = render(make_scene(mirror, wall, lights=[((0, 0, 0), (1, 1, 1))], **far), method).color[0, 0]
        assert color == pytest.approx([seen] * 3, abs=1e-12)
    beyond = make_scene(thing("plane", (0, 0, 30.5), a=0, b=0, c=-1))
    assert beyond.tracing.max_distance == 30 and shoot(beyond, (0, 0, 0), FORWARD, method).index.tolist() == [-1]


# --- M6 ------------------------------------------------------------------------------------------------------------
@pytest.mark.parametrize("scale", ["1e-9", "1", "1e12"])
def test_M6_newton_s_stop_does_not_depend_on_the_scale_of_f(scale):
    """f and c f have the same zeros; a bound on |f| would stop at the step's middle, or never."""
    scene = make_scene(formula(f"{scale}*(x**2 + y**2 + (z - 4.03)**2 - 1)"), step_size=0.1)
    assert shoot(scene, (0, 0, 0), FORWARD, "paper").t == pytest.approx(3.03, rel=1e-12)


def _literal_newton(g, slope, t, tolerance, most):
    for _ in range(most):
        dt = g(t) / slope(t)
        t -= dt
        if abs(dt) <= tolerance * max(1, abs(t)):
            break
    return t


@pytest.mark.parametrize("tolerance, most", [(1e-12, 20), (1e-12, 1), (1e-12, 3), (1e-2, 20)])
def test_M6_newton_runs_as_written(tolerance, most):
    """The same iteration, written out in Python: its last iterate is the answer, after the given number of steps and
    wherever it lies. tan(3 (z - 2.1)) / (1 + ...) has flat flanks: the iterates leave the step from 2 to 3."""
    text = "-(z - 2.1)/(1 + 9*(z - 2.1)**2)"
    g = lambda t: -(t - 2.1) / (1 + 9 * (t - 2.1)**2)
    slope = lambda t: -(1 - 9 * (t - 2.1)**2) / (1 + 9 * (t - 2.1)**2)**2
    expected = _literal_newton(g, slope, 2.5, tolerance, most)
    scene = make_scene(formula(text), step_size=1, tolerance=tolerance, max_iterations=most, max_distance=30)
    found = shoot(scene, (0, 0, 0), FORWARD, "paper")
    assert found.t == pytest.approx(expected, rel=1e-9)
    if most == 20:
        assert not 2 < expected < 3
    assert shoot(scene, (0, 0, 0), FORWARD, "exact").t == pytest.approx(2.1, rel=1e-14)


# --- M7 ------------------------------------------------------------------------------------------------------------
def test_M7_nan_is_outside_for_the_literal_method():
    """log(z - 2.1) does not exist up to z = 2.1 and is negative (inside) up to 3.1. The ray starts outside; the sample
    2.25 is the first inside, and Newton from 2.125 finds the zero at 3.1. 1 + sqrt(4 - z) is never negative: no hit."""
    found = shoot(make_scene(formula("log(z - 2.1)"), step_size=0.25), (0, 0, 0), FORWARD, "paper")
    assert found.index.tolist() == [0] and found.t == pytest.approx(3.1, rel=1e-12) and found.order == 2.25
    root = make_scene(formula("1 + sqrt(4 - z)"), step_size=0.25)
    assert shoot(root, (0, 0, 0), FORWARD, "paper").index.tolist() == [-1]


def test_M7_minus_infinity_is_not_finite_either():
    """log(z - 2) is minus infinity at the sample 2 and negative at 2.25: the change of sign is found at 2.25."""
    found = shoot(make_scene(formula("log(z - 2)"), step_size=0.25), (0, 0, 0), FORWARD, "paper")
    assert found.order == 2.25 and found.t == pytest.approx(3, rel=1e-12)


@pytest.mark.parametrize("text", ["log(z - 2)", "log(z - 2.1)", "1 + sqrt(4 - z)", "1/(z - 3)", "x**0.5 + 1 - z"])
def test_M7_the_exact_method_says_that_it_cannot_tell(text):
    """Where f is not finite on the way, or jumps through a pole, the ray is undecided; x^0.5 = exp(0.5 log x)."""
    scene = make_scene(formula(text))
    assert shoot(scene, (-0.5, 0, 0), FORWARD, "exact").undecided.tolist() == [True]
    assert render(make_scene(formula(text), camera={"position": [-0.5, 0, 0]})).status.tolist() == [[UNDECIDED]]


# --- O3, O4 --------------------------------------------------------------------------------------------------------
@pytest.mark.parametrize("method", BASIC)
def test_O3_objects_are_turned_about_their_centre(method):
    """An ellipsoid of semi-axes 1, 2, 3 about (0, 0, 6), its z axis turned to x, x to y, y to z (120 degrees about
    (1, 1, 1)): along z its semi-axis is now 2, so the camera meets it at 4, and along x 3."""
    scene = make_scene(thing("ellipsoid", (0, 0, 6), a=1, b=2, c=3, rotation={"axis": [1, 1, 1], "degrees": 120}))
    found = shoot(scene, [(0, 0, 0), (9, 0, 6), (0, 9, 6)], [(0, 0, 1), (-1, 0, 0), (0, -1, 0)], method)
    np.testing.assert_allclose(found.t, [4, 6, 8], rtol=1e-11)


@pytest.mark.parametrize("method", BASIC)
def test_O4_a_spindle_torus_is_crossed_twice(method):
    """R = 0.5, r = 1: along the line y = 0.1, z = 0 it is entered and left at x = -+ sqrt(1.5^2 - 0.1^2); the
    polynomial form's inner sheet, rho = r - R = 0.5, is not there. T = 1/2: the light keeps 1/4."""
    scene = make_scene(thing("torus", R=0.5, r=1, material={"transparency": 0.5}), step_size=0.05)
    found = shoot(scene, (-4, 0.1, 0), (1, 0, 0), method)
    assert found.t == pytest.approx(4 - np.sqrt(1.5**2 - 0.01), rel=1e-12)
    assert shine(scene, (-4, 0.1, 0), (1, 0, 0), 9.0, method).tolist() == [0.25]


def test_O4_on_the_axis_of_the_torus_a_pixel_is_undecided():
    scene = make_scene(thing("torus", (0, 0, 5), R=0.5, r=1), lights=[((0, 0, 0), (1, 1, 1))])
    assert render(scene, "paper").status.tolist() == [[UNDECIDED]]


# --- N1, R4 --------------------------------------------------------------------------------------------------------
@pytest.mark.parametrize("method", TRUTHS)
@pytest.mark.parametrize("inside", ["negative", "positive"])
def test_N1_the_normal_is_turned_against_the_ray(inside, method):
    """Seen from without and from within a ball: in either case normal . d < 0, and lit from the camera it is bright.
    The flip of the surface's sign (O1) changes nothing of what is seen."""
    for center in ((0, 0, 5), (0, 0, 0.5)):
        picture = render(make_scene(thing("sphere", center, r=2, inside=inside), size=(9, 7), camera={"fov": 30},
                                    lights=[((0, 0, 0), (1, 1, 1))]), method)
        d = unit(picture.position)
        assert np.all(picture.index == 0) and np.all(np.sum(picture.normal * d, axis=-1) < 0)
        np.testing.assert_allclose(np.abs(picture.normal), np.abs(picture.position - center) / 2, atol=1e-12)
        np.testing.assert_allclose(picture.color[..., 0], -np.sum(picture.normal * d, axis=-1), atol=1e-12)


@pytest.mark.parametrize("method", TRUTHS)
def test_R4_directions_stay_of_unit_length_through_sixty_reflections(method):
    """A mirrored ball seen from within. Renormalised, every direction errs by a rounding or two; left alone, the
    length's error grows with every bounce."""
    ball = thing("sphere", (0, 0, 0.5), r=2, material={"reflection": 1})
    generations = follow(make_scene(ball, size=(12, 9), max_depth=60), method)
    assert len(generations) == 61 and len(generations[-1].pixel) == 108
    for generation in generations[1:]:
        np.testing.assert_allclose(np.sum(generation.d**2, axis=1), 1, rtol=0, atol=7e-16)


@pytest.mark.parametrize("method", TRUTHS)
@pytest.mark.parametrize("factor", ["1e-280", "1e-160", "1", "1e153", "1e154", "1e200", "1e290"])
def test_N1_a_normal_does_not_depend_on_the_scale_of_f(factor, method):
    """c f has the normals of f; the square of a gradient of size c leaves the floats beyond 1e154 and below 1e-154. The
    closed form of the unit ball's normal, and the light that it lets a lamp at the camera give."""
    ball = formula(f"{factor}*(x*x + y*y + z*z - 1)", center=(0, 0, 4))
    picture = render(make_scene(ball, size=(9, 7), camera={"fov": 25}, lights=[((0, 0, 0), (1, 1, 1))]), method)
    met = picture.index == 0
    assert met.sum() > 40 and not np.any(picture.status == UNDECIDED)
    np.testing.assert_allclose(picture.normal[met], (picture.position - (0, 0, 4))[met], rtol=0, atol=1e-11)
    cosine = -np.sum(picture.normal * unit(picture.position), axis=-1)
    np.testing.assert_allclose(picture.color[..., 0][met], cosine[met], rtol=0, atol=1e-11)


def test_N1_where_the_gradient_leaves_the_floats_a_pixel_is_undecided(as_written):
    """A gradient of 1e310 where f itself is finite; the literal method meets it at z = 4."""
    wave = make_scene(formula("1e308*sin(400 - 100*z)"), lights=[((0, 0, 0), (1, 1, 1))],
                      camera={"position": [0, 0, 3.9995]}, step_size=0.0002, max_distance=0.01)
    picture = render(wave, "paper")
    assert picture.index.tolist() == [[0]] and picture.status.tolist() == [[UNDECIDED]]
