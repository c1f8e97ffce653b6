"""`bounds` is a promise that is checked: proven, and methods rely on it; refuted, and the scene is refused; or neither."""

import json

import numpy as np
import pytest
from tracing_support import make_scene, random_rays, shine, shoot, thing

from raytruth.reference_tracer.certify import certify
from raytruth.reference_tracer.certify.text import told
from raytruth.reference_tracer.errors import InputError
from raytruth.reference_tracer.oracle import literal
from raytruth.reference_tracer.scene.load import parse_scene
from raytruth.reference_tracer.scene.promises import unproven
from raytruth.reference_tracer.surfaces import KINDS, Bounds, Ellipsoid, Expression, Heart, Sphere, Torus
from raytruth.reference_tracer.surfaces.outside import Outside, outside
from raytruth.reference_tracer.tracer.render import render

TURN = {"axis": [1, 1, 0], "degrees": 40}
QUARTIC = "x**4 + y**4 + z**4 - 1"
TORUS = "(x**2 + y**2 + z**2 + 0.55)**2 - 2.56*(x**2 + y**2)"  # R = 0.8, r = 0.3
UNKNOWABLE = "100*(sin(400*x) - sin(400*x))"  # zero; over a cell of any size that matters intervals do not see it
HIDDEN = f"min(x**2 + y**2 + z**2 - 1, (x - 3.1)**2 + (y - 0.2)**2 + (z - 0.3)**2 - 0.0225) + {UNKNOWABLE}"


def cube(half: float, center=(0, 0, 0)) -> dict:
    return {"low": [c - half for c in center], "high": [c + half for c in center]}


def formula(text: str, half: float = 1.1, center=(0, 0, 4), **rest) -> dict:
    return thing("expression", center, formula=text, **{"bounds": cube(half), **rest})


# --- proven --------------------------------------------------------------------------------------------------------
@pytest.mark.parametrize("surface", [Sphere(r=1.3), Ellipsoid(a=1.0, b=0.5, c=0.1), Torus(R=0.8, r=0.3),
                                     Torus(R=0.3, r=0.8), Heart()], ids=lambda s: s.family)
def test_every_box_of_a_built_in_surface_is_proven(surface):
    """Spheres, ellipsoids and tori touch their boxes: the margin that methods add is what makes the proof possible."""
    assert outside(surface, surface.box()).sign == surface.sign_outside == 1


@pytest.mark.parametrize("text, half, sign", [
    (QUARTIC, 1, 1), (QUARTIC, 1.5, 1), ("abs(x) + abs(y) + abs(z) - 1", 1, 1), (TORUS, 1.1, 1), (f"-({TORUS})", 1.1, -1),
    ("1 - x**2 - y**2 - z**2", 1, -1), ("1/(x**2 + y**2 + z**2) - 1", 1, -1), ("exp(x**2 + y**2 + z**2) - 2", 1, 1),
    ("x**2 + y**2 + z**2 - 1 + 0.1*sin(10*x)*sin(10*y)*sin(10*z)", 1.2, 1),
    ("(x - 0.1)**6 + (y + 0.2)**6 + (1.5*z)**6 + x*y*z - 0.3", 1.4, 1),
    ("max(abs(sin(6*x)*cos(y*6) + sin(y*6)*cos(z*6) + sin(z*6)*cos(x*6)) - 0.2, sqrt(x**2 + y**2 + z**2) - 1)", 1, 1)])
def test_true_bounds_are_proven_and_relied_upon(text, half, sign):
    surface = Expression(formula=text, bounds=Bounds(low=(-half,) * 3, high=(half,) * 3))
    assert surface.sign_outside == sign and surface.box() == surface.bounds.corners


def test_bounds_too_small_by_less_than_the_margin_are_proven_too():
    """1 - 1e-7 of the unit ball is within the margin that is added everywhere; 1 - 1e-5 is not."""
    fits = lambda half: outside(Expression(formula=QUARTIC), ((-half,) * 3, (half,) * 3)).sign
    assert fits(1 - 1e-7) == 1 and fits(1 - 1e-5) == 0


# --- refuted -------------------------------------------------------------------------------------------------------
REFUTED = {
    "ball": (formula("x**2 + y**2 + z**2 - 1", 0.8), "x = -0.8"),
    "quartic": (formula(QUARTIC, 0.8), "x = -0.8"),
    "turned": (formula("x**2 + y**3 - z**2", 2, (0, 0, 7), rotation=TURN), "x = -2"),
    "positive": (formula(f"-({QUARTIC})", 0.8, inside="positive"), "x = -0.8"),
    "one face": (formula(QUARTIC, bounds={"low": [-1, -1, -1], "high": [1, 0.9, 1]}), "y = 0.9"),
    "moved": (formula("(x - 0.3)**2 + y**2 + z**2 - 1", 1), "x = 1"),
    "cylinder": (formula("x**2 + y**2 - 1", 1.5), "z = -1.5"),
    "pole": (formula("1/x + y**2 + z**2 + 100*x**2 - 4", 1), "y = -1"),
    "domain": (formula("sqrt(x) + y**2 + z**2 - 2", bounds={"low": [0.1, -2, -2], "high": [5, 2, 2]}), "x = 0.1"),
    "second part": (formula("(x**2 + y**2 + z**2 - 1)*((x - 6)**2 + y**2 + z**2 - 0.25)", 1.2), ""),
    "small part": (formula("min(x**2 + y**2 + z**2 - 1, (x - 3.1)**2 + y**2 + (z - 0.3)**2 - 1e-6)"), ""),
    "waves": (formula("cos(x) + cos(y) + cos(z) - 2.5", 1.2), "")}


@pytest.mark.parametrize("name", REFUTED)
def test_a_broken_promise_is_refused_with_the_face_and_points(name):
    """Both points are outside, or on the face that is named; f has the signs there that are told."""
    thing_, face = REFUTED[name]
    thing_ = thing_ | {"name": "the odd one"}
    with pytest.raises(InputError) as refused:
        make_scene(thing_)
    sentence = str(refused.value)
    assert "objects[0].surface.bounds (the odd one)" in sentence and '"clip"' in sentence and "\n" not in sentence
    assert ("on the face" in sentence) == bool(face) and face in sentence

    surface = Expression.model_validate_json(json.dumps(thing_["surface"]))
    found = outside(surface, surface.bounds.corners, ((-45.0,) * 3, (45.0,) * 3))
    low, high = map(np.array, surface.bounds.corners)
    for point, sign in zip(found.change, (1, -1)):
        assert np.sign(surface.function(*point)) == sign and (np.less(point, low) | np.greater(point, high)).any()


def test_what_no_ray_reaches_breaks_no_promise():
    """The second ball is 6 away: within reach of rays that end after 20, not of those that end after 5."""
    two = formula("(x**2 + y**2 + z**2 - 1)*((x - 6)**2 + (y - 6)**2 + z**2 - 0.25)", 1.2)
    with pytest.raises(InputError, match="where rays get"):
        make_scene(two, max_distance=20)
    scene = make_scene(two, max_distance=5)
    assert unproven(scene) == ["expression (object 0)"]  # somewhere it is broken: nothing relies on it


def test_a_thousand_alike_are_checked_once():
    """And the same formula with true and false bounds is judged object by object."""
    balls = [formula(QUARTIC, 1.1, (k, 0, 4)) for k in range(20)]
    assert not unproven(make_scene(*balls))
    with pytest.raises(InputError, match=r"objects\[20\]"):
        make_scene(*balls, formula(QUARTIC, 0.9))


# --- neither -------------------------------------------------------------------------------------------------------
def test_nothing_relies_on_bounds_that_are_not_proven():
    """Bounds that leave out a second ball, which no search sees: every method meets it all the same."""
    hidden = formula(HIDDEN, 1.1, (0, 0, 0))
    scene = make_scene(hidden)
    assert unproven(scene) == ["expression (object 0)"] and scene.objects[0].surface.region() is not None
    for method in ("paper", "exact", "interval"):
        found = shoot(scene, (3.1, 0.2, -3), (0, 0, 1), method, inside=[[False]])
        assert found.index == 0 and found.t == pytest.approx(3.3 - 0.15, abs=1e-9), method
        assert shine(scene, (3.1, 0.2, -3), (0, 0, 1), 6.0, method)[0] == 0
    # in the way of a proven one of the same kind, and among many, whose balls are asked first
    others = [formula("x**2 + y**2 + z**2 - 1", 1.1, (0, 5 + k, 0)) for k in range(3)]
    many = make_scene(*[formula(HIDDEN, 1.1, (0, 0, 9 * k)) for k in range(20)], *others)
    assert shoot(many, (3.1, 0.2, -3), (0, 0, 1), "exact", inside=[[False] * 23]).t == pytest.approx(3.15, abs=1e-9)


def test_paper_equals_the_literal_search_whatever_the_promise():
    """literal.py knows no boxes at all."""
    scene = make_scene(formula(HIDDEN, 1.1, (-1.1, 0, 6), rotation={"axis": [0, 1, 0], "degrees": 20}), size=(40, 30),
                       camera={"fov": 16, "direction": [1.8, 0, 5]}, lights=[((2, 3, -1), (1, 1, 1))])
    picture = render(scene, "paper")
    assert np.abs(picture.color - literal.render(scene)).max() < 1e-9
    small = (picture.index == 0) & (np.abs(picture.position[..., 0]) > 1.2)
    assert small.sum() > 10


def test_certificates_say_what_is_not_proven():
    scene = make_scene(formula("x**2 + y**2 + z**2 - 1 + 0*sqrt(z + 20)"), size=(8, 6))  # not defined behind the camera
    certificate = certify(scene, sample=10, paths=0)
    assert certificate.document()["unproven_bounds"] == ["expression (object 0)"]
    assert "bounds not proven: expression (object 0)" in told(certificate)
    assert "not proven" not in told(certify(make_scene(formula(QUARTIC), size=(8, 6)), sample=10, paths=0))


# --- the side outside ----------------------------------------------------------------------------------------------
WAYS = {  # the unit ball, and all but the ball
    "f": ("x**2 + y**2 + z**2 - 1", "negative", True), "-f, positive": ("1 - x**2 - y**2 - z**2", "positive", True),
    "-f": ("1 - x**2 - y**2 - z**2", "negative", False), "f, positive": ("x**2 + y**2 + z**2 - 1", "positive", False),
    "no degree": ("sqrt(x**2 + y**2 + z**2) - 1", "negative", True),
    "no degree, -f": ("1 - sqrt(x**2 + y**2 + z**2)", "negative", False),
    "no degree, -f, positive": ("1 - sqrt(x**2 + y**2 + z**2)", "positive", True),
    "degree 4, -f, positive": ("1 - (x**2 + y**2 + z**2)**2", "positive", True)}


@pytest.mark.parametrize("method", ["paper", "exact", "interval", "proof", "descartes"])
@pytest.mark.parametrize("way", WAYS)
def test_f_may_have_either_sign_outside(way, method):
    """Rays from 6 away to the unit ball, and from within it, meet it where the ball's quadratic equation says."""
    text, inside, is_ball = WAYS[way]
    scene = make_scene(thing("expression", formula=text, inside=inside, bounds=cube(1)), step_size=0.01)
    o, d = random_rays(200, seed=3)
    b, c = np.einsum("ij,ij->i", o, d), 35.0
    meets = b * b > c + 0.05
    o, d, b = o[meets], d[meets], b[meets]
    root = np.sqrt(b * b - c)
    found = shoot(scene, o, d, method)
    assert np.abs(found.t - (-b - root)).max() < 1e-9 and not found.undecided.any()
    middle = o + -b[:, None] * d
    found = shoot(scene, middle, d, method)
    assert np.abs(found.t - root).max() < 1e-9
    assert (shine(scene, o, d, 12.0, method) == 0).all()
    assert scene.objects[0].surface(0, 0, 0) * (1 if is_ball else -1) < 0


def test_one_formula_bounded_and_unbounded_in_one_scene():
    """The same f with and without bounds, of either side: each is met where its own ball stands."""
    ball = "x**2 + y**2 + z**2 - 1"
    scene = make_scene(thing("expression", (0, 0, 4), formula=ball, bounds=cube(1)),
                       thing("expression", (4, 0, 4), formula=ball), formula(f"{ball} + {UNKNOWABLE}", 1.1, (8, 0, 4)))
    found = shoot(scene, [(0, 0, 0), (4, 0, 0), (8, 0, 0)], (0, 0, 1))
    assert found.index.tolist() == [0, 1, 2] and np.abs(found.t - 3).max() < 1e-12


def test_a_file_says_it_before_anything_is_traced():
    document = {"objects": [formula(QUARTIC, 0.8)]}
    with pytest.raises(InputError, match="bounds do not hold"):
        parse_scene(json.dumps(document).encode())
    assert all("clip" in kind.model_fields for kind in KINDS)


def test_signs_that_no_way_joins_break_no_promise():
    """A cap: above it f > 0, below it f < 0, and f is not defined around the cylinder between: no zero lies outside."""
    cap, box = Expression(formula="z - sqrt(0.75 - x**2 - y**2)"), ((-0.9,) * 3, (0.9,) * 3)
    assert outside(cap, box) == Outside(0)
    # as soon as f is defined there, the sheet goes on outside
    for f in ("z - sqrt(0.75 + 0.1*x**2 + 0.1*y**2)", "z - sqrt(abs(0.75 - x**2 - y**2))"):
        assert outside(Expression(formula=f), box).change


def test_where_f_is_not_defined_no_box_is_put_around_what_is_inside():
    """max(z - sqrt(1 - x^2 - y^2), -z) > 0 outside of its box wherever it is defined, and undefined elsewhere (M7)."""
    dome = "max(z - sqrt(1 - x**2 - y**2), -z)"
    found = outside(Expression(formula=dome), ((-1.01,) * 3, (1.01,) * 3))
    assert found.sign == 1 and not found.defined
    bounds = Bounds(low=(-1.01,) * 3, high=(1.01,) * 3)
    assert Expression(formula=dome, bounds=bounds).box() and not Expression(formula=dome, bounds=bounds, inside="positive").box()
    assert not outside(Expression(formula=f"{dome} + 1/x"), ((-1.01,) * 3, (1.01,) * 3)).sign
