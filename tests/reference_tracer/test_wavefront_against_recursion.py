"""The fast tracer against the recursive oracle: two programs, one picture, to 1e-12.

For `paper` the oracle marches as sections 4.1 and 4.2 say (all_steps.AllSteps: literal.LiteralSearch with the loop
over steps made an axis); for `exact` it takes its hits from closed_forms.Exact.
"""

import numpy as np
import pytest
from all_steps import AllSteps
from closed_forms import Exact
from tracing_support import make_scene, thing

from raytruth.reference_tracer.oracle import literal
from raytruth.reference_tracer.scene import library
from raytruth.reference_tracer.tracer.render import render

TOLERANCE = 1e-12


def affordable(scene):
    """The scene at a size and a depth at which the oracle, which follows every path on its own, takes seconds.

    An odd width and an even height keep pixel centres off the edges of the rooms of figures 10 to 16 (x : y = 7 : 5),
    where two walls are met at one t and rounding alone says which.
    """
    splitting = sum(o.material.reflection > 0 or o.material.transparency > 0 for o in scene.objects)
    width, depth = (25, 8) if splitting < 2 else (17, 3)
    height = 2 * round(width * scene.camera.height / scene.camera.width / 2)
    return scene.resized(width, height, samples=1).traced_with(max_depth=min(depth, scene.tracing.max_depth))


@pytest.mark.parametrize("name", library.names())
def test_paper_on_every_shipped_scene(name):
    scene = affordable(library.scene(name))
    expected = literal.render(scene, AllSteps(scene))
    assert np.ptp(expected) > 0.05
    np.testing.assert_allclose(render(scene, "paper").color, expected, rtol=0, atol=TOLERANCE)


def _with_closed_forms() -> list[str]:
    """One scene of each geometry (figures 10 to 16 share theirs) but for those with typed formulas, a torus that
    overlaps itself, or the heart, whose belt is a triple root."""
    possible = lambda s: s.type not in ("heart", "expression") and (s.type != "torus" or s.r < s.R)
    geometries = {}
    for name in library.names():
        surfaces = tuple(o.surface for o in library.scene(name).objects)
        if all(map(possible, surfaces)):
            geometries.setdefault(surfaces, name)
    return list(geometries.values())


@pytest.mark.parametrize("name", _with_closed_forms())
def test_exact_on_every_shipped_geometry_with_closed_forms(name):
    scene = affordable(library.scene(name))
    expected = literal.render(scene, Exact(scene))
    np.testing.assert_allclose(render(scene, "exact").color, expected, rtol=0, atol=TOLERANCE)


GLASS = {"color": [0.2, 0.3, 0.2], "reflection": 0.2, "transparency": 0.7, "refractive_index": 1.4}
MIRROR = {"color": [0.9, 0.9, 0.9], "reflection": 0.7}
MATTE = {"color": [0.9, 0.5, 0.3]}
FLOOR = thing("plane", (0, -1.2, 0), a=0, b=1, c=0.05, material={"color": [0.6, 0.7, 0.9], "reflection": 0.2})
LIGHTS = [((3, 4, -1), (0.7, 0.6, 0.5)), ((-3, 2, 3), (0.2, 0.3, 0.4))]
TURN = {"axis": [1, 2, 0.3], "degrees": 40}
COMMON = {"lights": LIGHTS, "size": (20, 15), "background": (0.1, 0.2, 0.3), "max_depth": 4, "max_distance": 12}

SCENES = {
    "balls of glass and of mirror": ([thing("sphere", (-0.6, 0, 4), r=1, material=GLASS),
                                      thing("sphere", (1, -0.2, 5), r=1, material=MIRROR), FLOOR], {}),
    "glass in glass, camera inside": ([thing("sphere", (0, 0, 1), r=3, material=GLASS | {"refractive_index": 1.1}),
                                       thing("sphere", (0.2, 0, 2), r=0.8, material=GLASS), FLOOR], {"size": (12, 9)}),
    "turned quadrics": ([thing("ellipsoid", (-0.8, 0, 4), a=0.6, b=1.2, c=0.8, rotation=TURN, material=GLASS),
                         thing("paraboloid", (1, -0.5, 5), a=0.6, b=0.8, rotation=TURN, material=MIRROR), FLOOR], {}),
    "torus of glass": ([thing("torus", (0, 0, 4), R=1, r=0.35, rotation=TURN, material=GLASS),
                        thing("sphere", (0.3, 0.1, 6), r=0.8, material=MATTE), FLOOR],
                        {"size": (16, 12), "max_depth": 3}),
    "flipped side": ([thing("sphere", (0, 0, 4), r=1, inside="positive", material=GLASS), FLOOR], {}),
    "samples": ([thing("sphere", (0, 0, 4), r=1, material=MIRROR), FLOOR], {"samples": 2, "size": (16, 12)}),
}
# defined, without poles, wherever a ray may get to: next to a pole Newton's literal iterates are chaos
EVERY_FUNCTION = ("x**2 + y**2 + z**2 - 1.2 + 0.2*sin(3*x)*cos(2*y) + tan(z/20) + 0.1*exp(x) - log(z + 20)"
                  " + 0.5*sqrt(x + 20) + 0.3*cbrt(y + 20) + 0.3*abs(x - 0.1) + 0.2*max(y, 0.2 + x) + 0.2*min(z, 0.1 - y)"
                  " + x/(y + 20) + 3/(z + 20) + 100*(y + 20)**-2 - 0.02*(x + 20)**1.5 + (z/20 + 1)**(x/20 + 1) - 0.05*2**z")
MARCHED = {
    "hearts": ([thing("heart", (-0.4, 0.2, 3), material=MIRROR, rotation=TURN), FLOOR], {}),
    "formula": ([thing("expression", (0, 0, 4), formula="x**4 + y**4 + z**4 - 1 + 0.2*sin(5*x)", material=GLASS,
                       bounds={"low": [-1.3, -1.3, -1.3], "high": [1.3, 1.3, 1.3]}), FLOOR], {}),
    "every function": ([thing("expression", (0, 0, 4), formula=EVERY_FUNCTION, material=MIRROR), FLOOR],
                       {"step_size": 0.05}),
    "spindle": ([thing("torus", (0, 0, 4), R=0.4, r=0.8, rotation=TURN, material=MIRROR), FLOOR], {}),
    "as printed": ([thing("sphere", (-0.6, 0, 4), r=1, material=GLASS), FLOOR], {"refraction": "as_printed"}),
    "large steps": ([thing("sphere", (-0.6, 0, 4), r=1, material=GLASS), thing("sphere", (1, 0, 4), r=0.5), FLOOR],
                    {"step_size": 0.7}),
    "few iterations": ([thing("sphere", (-0.6, 0, 4), r=1, material=MIRROR), FLOOR],
                       {"max_iterations": 2, "tolerance": 1e-3}),
}


@pytest.mark.parametrize("name", SCENES)
def test_exact_on_small_scenes(name):
    objects, rest = SCENES[name]
    scene = make_scene(*objects, **{**COMMON, **rest})
    expected = literal.render(scene, Exact(scene))
    assert np.ptp(expected) > 0.2
    np.testing.assert_allclose(render(scene, "exact").color, expected, rtol=0, atol=TOLERANCE)


@pytest.mark.parametrize("name", {**SCENES, **MARCHED})
def test_paper_on_small_scenes(name):
    objects, rest = {**SCENES, **MARCHED}[name]
    scene = make_scene(*objects, **{**COMMON, **rest})
    expected = literal.render(scene, AllSteps(scene))
    assert np.ptp(expected) > 0.2
    np.testing.assert_allclose(render(scene, "paper").color, expected, rtol=0, atol=TOLERANCE)


@pytest.mark.parametrize("name", ["glass in glass, camera inside", "torus of glass", "large steps", "hearts"])
def test_all_steps_at_once_are_the_literal_steps_one_by_one(name):
    """The two searches of the oracle agree to the last bit but for the order of products."""
    objects, rest = {**SCENES, **MARCHED}[name]
    scene = make_scene(*objects, **{**COMMON, **rest, "size": (8, 6), "max_depth": 2})
    np.testing.assert_allclose(literal.render(scene, AllSteps(scene)), literal.render(scene), rtol=1e-14)


def test_the_comparison_can_fail():
    """One changed number in one of two equal scenes is seen."""
    objects, rest = SCENES["balls of glass and of mirror"]
    scene = make_scene(*objects, **{**COMMON, **rest})
    other = make_scene(*objects, **{**COMMON, **rest, "max_depth": 3})
    assert np.abs(render(scene, "exact").color - literal.render(other, Exact(other))).max() > 1e-4
