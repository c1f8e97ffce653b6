"""Scenes as text for POV-Ray: what is written, what is proven about it, what is refused."""

import math
import re

import numpy as np
import pytest

from raytruth.converters.mesh.placed import Placed
from raytruth.converters.povray import convert, object_of, scene_text
from raytruth.converters.povray.distance import far_shadows
from raytruth.converters.povray.gradient import max_gradient
from raytruth.converters.povray.text import function_text
from raytruth.reference_tracer.errors import InputError, UnsupportedError
from raytruth.reference_tracer.scene import library
from raytruth.reference_tracer.scene.model import Camera, Light, Material, Object, Tracing
from raytruth.reference_tracer.surfaces import Expression, Heart, Paraboloid, Plane, Sphere, Torus
from raytruth.reference_tracer.surfaces.expression import Bounds

VOCABULARY = {"sqrt": np.sqrt, "Cbrt": np.cbrt, "sin": np.sin, "cos": np.cos, "tan": np.tan, "exp": np.exp, "ln": np.log,
              "abs": np.abs, "min": np.minimum, "max": np.maximum, "pow": np.power}
FORMULAS = ("max(abs(x)**3, min(cbrt(y - 0.1), 2)) * exp(-z**2) - x", "log(2 + x**2)**3 / tan(1 + y**2)",
            "sqrt(x**2 + 1) - sin(y)*cos(z) - -2", "(x - y)**-2 - 2**-3*z**5", "abs(x)**1.5 - 1e-7*y + 2e+30*z")


def glass(center=(0.0, 0.0, 4.0), r=1.0, n=1.3):
    return Object(surface=Sphere(center=center, r=r), material=Material(transparency=0.8, refractive_index=n))


@pytest.mark.parametrize("surface", [Heart(), Torus(R=1.0, r=0.25), Plane(a=-1.0, b=0.5, c=2.0), Paraboloid(a=0.5, b=2.0),
                                     *(Expression(formula=f) for f in FORMULAS)], ids=lambda s: getattr(s, "formula", s.type))
def test_the_text_is_the_function(surface):
    """Read back by the rules of SDL, which for these are Python's, the text has the surface's own values."""
    points = np.random.default_rng(1).uniform(-1.5, 1.5, (3, 200))
    text = function_text(surface)
    read = eval(text, {"__builtins__": {}, **VOCABULARY}, dict(zip("xyz", points)))
    assert np.allclose(read, surface.regular(*points), rtol=1e-13, atol=1e-13)


def test_the_text_is_as_long_as_the_formula():
    nested = "x"
    for _ in range(18):
        nested = f"cbrt(abs({nested} + y))"
    assert len(function_text(Expression(formula=nested))) < 2 * len(nested)


def test_no_word_of_the_scene_file_gets_into_the_text(scene_of):
    evil = 'x } #include "/etc/passwd" // object 7'
    ball = Object(name=evil, surface=Expression(formula="x**2 + y**2 + z**2 - 1", center=(0.0, 0.0, 4.0)))
    text = scene_text(scene_of(ball, title=evil, description=evil))
    assert "passwd" not in text and "#include" not in text
    assert {object_of(line) for line in text.splitlines() if "isosurface" in line} == {0}


def test_numbers_keep_every_digit(scene_of):
    r = 1 / 3 + 1e-16
    scene = scene_of(Sphere(center=(0.1, 0.0, 4.0), r=r), tracing=Tracing(max_distance=10.0))
    x, _, _, radius = map(float, re.search(r"sphere \{ <(.*),(.*),(.*)>, (\S+)", scene_text(scene)).groups())
    assert radius == 1e6 * r and x == 1e6 * 0.1  # rays end at 1e7, the scene's at 10


@pytest.mark.parametrize("surface, proven", [(Sphere(r=1.5), True), (Torus(R=1.0, r=0.25), False), (Heart(), False),
                                             (Expression(formula="x**4+y**4+z**4-1", bounds=Bounds(
                                                 low=(-1.0,) * 3, high=(1.0,) * 3)), True)])
def test_max_gradient_bounds_the_gradient(surface, proven):
    placed = Placed(Object(surface=surface))
    bound, is_proven = max_gradient(placed, placed.box)
    points = np.random.default_rng(2).uniform(*placed.box, (20000, 3))
    found = np.nanmax(np.linalg.norm(placed.gradient(points)[1], axis=1))
    assert is_proven == proven and bound <= 2 * found  # no more than twice too slow
    assert found <= bound or not proven


def test_max_gradient_of_a_plane_is_exact():
    box = np.array([[-1.0] * 3, [1.0] * 3])
    assert max_gradient(Placed(Object(surface=Plane(a=3.0, b=0.0, c=4.0))), box) == (pytest.approx(5), True)


@pytest.mark.parametrize("inner, expected", [(glass(r=0.5, n=1.4), 1.3 * 1.4), (glass(r=0.5, n=0.8), 1.3 * 0.8),
                                             (glass((0.0, 0.0, 7.0), 0.5, 1.4), 1.4)], ids=["within", "lighter", "apart"])
def test_indices_of_nested_glass_multiply(scene_of, inner, expected):
    for objects in ([glass(), inner], [inner, glass()]):
        indices = convert(scene_of(*objects)).indices
        assert indices[objects.index(inner)] == pytest.approx(expected, rel=1e-7)
        assert indices[1 - objects.index(inner)] == pytest.approx(1.3, rel=1e-7)


def test_equal_media_still_count_as_a_generation(scene_of):
    """POV-Ray passes from a medium to an equal one without a ray of its own: the last digit of fp32 tells them apart."""
    outer, inner = convert(scene_of(glass(n=1.0), glass(r=0.5, n=1.0))).indices
    assert 1 < outer < inner < 1 + 1e-6 or outer == 1 + 2**-23


@pytest.mark.parametrize("other", [glass((0.9, 0.0, 4.0), 0.5, 1.4), glass((0.5, 0.0, 4.0), 0.5, 1.4), glass(r=1.0, n=1.4)],
                         ids=["overlaps", "touches from within", "same place"])
def test_overlapping_glass_is_refused(scene_of, other):
    with pytest.raises(UnsupportedError, match="transparent and may overlap"):
        convert(scene_of(glass(), other))


@pytest.mark.parametrize("changes, word", [({"refraction": "as_printed"}, "E1"), ({"cutoff": 0.1}, "cutoff"),
                                           ({"adaptive": 0.1}, "adaptive"), ({"effects": ("shadow",)}, "leave out")])
def test_what_pov_ray_cannot_express_is_refused(scene_of, changes, word):
    with pytest.raises(UnsupportedError, match=word):
        convert(scene_of(glass(), tracing=Tracing(**changes)))


def test_an_unbounded_isosurface_among_mirrors_is_refused(scene_of):
    wave = Expression(formula="y + 1 + sin(x)")
    convert(scene_of(wave))
    with pytest.raises(UnsupportedError, match="unbounded isosurface"):
        convert(scene_of(wave, glass()))


def test_options_are_checked(scene_of):
    for options, word in (({"shapes": "mesh"}, "native, isosurface"), ({"accuracy": 0.0}, "accuracy")):
        with pytest.raises(InputError, match=word):
            convert(scene_of(Sphere(r=1.0)), **options)


def test_lights_hidden_from_afar(scene_of):
    """A ball 9 above the floor, the lamp 10 above: its shadow falls more than 5 behind it, where POV-Ray sees no more."""
    floor, ball = Plane(a=0.0, b=1.0, c=0.0, center=(0.0, -1.0, 0.0)), Sphere(center=(0.0, 8.0, 3.0), r=0.4)
    parts = {"lights": (Light(position=(0.0, 9.0, 3.0)),), "camera": Camera(width=8, height=8)}
    assert "may hide light 1" in far_shadows(scene_of(floor, ball, tracing=Tracing(max_distance=5.0), **parts))
    assert far_shadows(scene_of(floor, ball, tracing=Tracing(max_distance=50.0), **parts)) == ""


def test_every_shipped_scene_can_be_expressed():
    remarked = [name for name in (*library.names(), *library.effects()) if convert(library.find(name)).remark]
    rooms = [name for name in library.names() if "refraction" in name or "scene3" in name]  # a ball behind the camera
    assert remarked == [*rooms, "figure-reflection"]


def test_weights_of_glass_add_up(scene_of):
    """What is kept, reflected and let through: (1-R)(1-T), R(1-T) and T, and T + R(1-T) in total reflection (R3)."""
    for R, T in ((0.0, 0.5), (0.3, 0.6), (0.0, 1.0), (1.0, 0.4), (0.2, 0.999)):
        ball = Object(surface=Sphere(center=(0.0, 0.0, 4.0), r=1.0), material=Material(reflection=R, transparency=T))
        text = scene_text(scene_of(ball))
        transmitted = float(re.search(r"rgbt <[^>]*,([^,>]+)>", text)[1])
        number = lambda name: float(re.search(name + r"\s*\{?\s*([\d.e+-]+)", text)[1])
        assert number("refraction") * transmitted == pytest.approx(T, abs=1e-12)
        assert number("refraction") == pytest.approx(T + R * (1 - T), rel=1e-5)
        assert number(r"finish \{ diffuse") * (1 - transmitted) == pytest.approx((1 - R) * (1 - T), abs=1e-12)
        assert number(r"reflection \{") == pytest.approx(R * (1 - T)) and math.isfinite(transmitted)


def test_rays_that_start_on_an_isosurface_see_all_its_roots(scene_of):
    """The first one may be the ray's own origin, and the shadow of the next would be lost."""
    converted = convert(scene_of(Heart(center=(0.0, 0.0, 4.0))))
    assert "all_intersections" in converted.text() and "max_trace 1" not in converted.text()
    assert "max_trace 1" in converted.text("distance")
