"""Rows F1 to F6 of DECISIONS.md: what the document's figures do otherwise than its text, each from its closed form.

Every check also fails on a tracer that takes the row another way. The wavefront agrees with the recursion whatever is
switched on, and a kernel holds nothing of a switch that its scene does not use.
"""

import dataclasses
import math

import numpy as np
import pytest
from all_steps import AllSteps
from closed_forms import Exact
from test_wavefront_against_recursion import COMMON, FLOOR, GLASS, MIRROR, TOLERANCE
from tracing_support import follow, make_scene, thing, unit

from raytruth.reference_tracer.backend import backend
from raytruth.reference_tracer.errors import InputError
from raytruth.reference_tracer.oracle import literal
from raytruth.reference_tracer.scene.model import Scene
from raytruth.reference_tracer.tracer import world as worlds
from raytruth.reference_tracer.tracer.optics import Optics
from raytruth.reference_tracer.tracer.render import Renderer, render
from raytruth.reference_tracer.tracer.world import World

import drjit as dr  # isort: skip  # after the LLVM that it is to load has been chosen

METHODS = ("paper", "exact")
BOTH = pytest.mark.parametrize("method", METHODS)
WHITE, HALF = (1, 1, 1), (0.5, 0.5, 0.5)
BALL = thing("sphere", (0, 0, 5), r=1, material={"color": [0.8, 0.6, 0.4]})


def middle(scene, method="exact", world=World) -> np.ndarray:
    """The colour of the pixel in the middle of a picture of `scene`."""
    color = Renderer(scene, method, world=world).picture().color
    return color[color.shape[0] // 2, color.shape[1] // 2]


def with_formulas(formulas: type[Optics]) -> type[World]:
    return type(formulas.__name__, (World,), {"optics": formulas()})


def fails(check, *arguments, **wrong):
    """The check notices that."""
    with pytest.raises(AssertionError):
        check(*arguments, **wrong)


# --- F1 ------------------------------------------------------------------------------------------------------------
class AlwaysAdds(Optics):
    def combined(self, illumination, light, balanced):
        return super().combined(illumination, light, balanced=False)


class Clamps(Optics):
    def combined(self, illumination, light, balanced):
        return illumination + light - (illumination + light > 1) * (illumination + light - 1)


@BOTH
def test_F1_balanced_lights_share_what_is_dark_yet(method, world=World):
    """A lamp at the camera meets the ball at cos 1, one at (3, 0, 0) the point (0, 0, 4) at cos 4/5: 0.6 and 0.8 * 0.5
    make 1 - 0.4 * 0.6 in red; in green 0.3 and nothing make 0.3; in blue 2 and 0.4 make 1 - (-1) * 0.6, above one. By
    default they add up."""
    lights = [((0, 0, 0), (0.6, 0.3, 2)), ((3, 0, 0), (0.5, 0, 0.5)), ((0, 0, 9), WHITE)]  # the last one is behind (L2)
    balanced = middle(make_scene(BALL, lights=lights, lights_="balanced"), method, world)
    np.testing.assert_allclose(balanced, [0.8 * 0.76, 0.6 * 0.3, 0.4 * 1.6], rtol=1e-13)
    np.testing.assert_allclose(middle(make_scene(BALL, lights=lights), method, World), [0.8, 0.6 * 0.3, 0.4 * 2.4], rtol=1e-13)


@pytest.mark.parametrize("wrong", [AlwaysAdds, Clamps])
def test_F1_another_combination_is_noticed(wrong):
    fails(test_F1_balanced_lights_share_what_is_dark_yet, "exact", world=with_formulas(wrong))


# --- F2 ------------------------------------------------------------------------------------------------------------
AMBIENT = 0.25


class AmbientLast(Optics):
    """Adds ambient light to the lights' combination, of which it has to be a part."""

    def combined(self, illumination, light, balanced):
        return AMBIENT + super().combined(illumination - AMBIENT, light, balanced)


class AmbientOfTheUnlit(World):
    """Takes ambient light for a colour of its own, that no material weakens."""

    @property
    def background(self):
        return self._background

    @background.setter
    def background(self, value):
        self._background, self.ambient = value, 0.0


@BOTH
@pytest.mark.parametrize("lights, illumination", [("sum", AMBIENT + 0.6 + 0.4), ("balanced", 1 - 0.75 * 0.4 * 0.6)])
def test_F2_ambient_light_is_the_first_of_the_combination(method, lights, illumination, world=World):
    """Beside the lamps of F1, 0.6 and 0.8 * 0.5. R = 0.2, T = 0.5 leave (1 - R)(1 - T) = 0.4 of the ball's own colour."""
    lamps = [((0, 0, 0), (0.6, 0.6, 0.6)), ((3, 0, 0), HALF)]
    ball = {**BALL, "material": {"color": [0.8, 0.6, 0.4], "reflection": 0.2, "transparency": 0.5}}
    scene = make_scene(ball, lights=lamps, lights_=lights, ambient=AMBIENT, max_depth=0)
    np.testing.assert_allclose(middle(scene, method, world), 0.4 * illumination * np.array([0.8, 0.6, 0.4]), rtol=1e-13)


@BOTH
@pytest.mark.parametrize("lights", ["sum", "balanced"])
def test_F2_ambient_light_is_never_shadowed(method, lights):
    """The lamp is behind a wall, or there is none: what is left is the ambient light, at cos 1 wherever the normal points."""
    wall = thing("plane", (0, 0, -1), a=0, b=0, c=1)
    for lamps in ([((0, 0, -3), WHITE)], [((0, 0, 0), (0, 0, 0))]):
        scene = make_scene(BALL, wall, lights=lamps, lights_=lights, ambient=AMBIENT, size=(9, 7), camera={"fov": 12})
        color = render(scene, method).color
        np.testing.assert_allclose(color, np.broadcast_to([0.2, 0.15, 0.1], color.shape), rtol=1e-13)
    dark = make_scene(BALL, lights_=lights, ambient=AMBIENT).model_copy(update={"lights": ()})
    np.testing.assert_allclose(middle(dark, method), [0.2, 0.15, 0.1], rtol=1e-13)


def test_F2_ambient_light_in_another_place_is_noticed():
    fails(test_F2_ambient_light_is_the_first_of_the_combination, "exact", "balanced", 1 - 0.75 * 0.4 * 0.6,
          world=with_formulas(AmbientLast))
    fails(test_F2_ambient_light_is_the_first_of_the_combination, "exact", "sum", AMBIENT + 1, world=AmbientOfTheUnlit)


# --- F3 ------------------------------------------------------------------------------------------------------------
class OnlyTheClearest(Scene):
    """Lets only what is perfectly clear cast no shadow."""

    def casts_shadow(self, obj):
        return obj.shadow and not (self.tracing.shadows == "opaque_only" and obj.material.transparency >= 1)


@BOTH
@pytest.mark.parametrize("transparency, shadows, expected", [
    (0.6, "attenuate", 0.36), (0.6, "opaque_only", 1), (0.01, "opaque_only", 1), (0, "attenuate", 0), (0, "opaque_only", 0),
    (1, "opaque_only", 1)])
def test_F3_shadow_of_a_ball_of_glass(method, transparency, shadows, expected, kind=Scene):
    """The camera, below the ball, sees the floor that a lamp straight above it lights: through the ball, twice (L3)."""
    ball = thing("sphere", (0, 1, 3), r=0.5, material={"transparency": transparency, "refractive_index": 1.7})
    scene = make_scene(ball, thing("plane", (0, -1, 0), a=0, b=1, c=0), lights=[((0, 9, 3), WHITE)],
                       camera={"direction": [0, -1, 3]}, shadows=shadows)
    np.testing.assert_allclose(middle(kind.model_validate(scene.model_dump(by_alias=True)), method), [expected] * 3, rtol=1e-12)


@BOTH
def test_F3_what_is_opaque_still_hides_behind_glass(method):
    """And an object that casts none (`"shadow": false`) casts none whatever the switch says."""
    ball, core = (thing("sphere", (0, 1, 3), r=r, material={"transparency": t}) for r, t in ((0.5, 0.6), (0.2, 0)))
    floor = thing("plane", (0, -1, 0), a=0, b=1, c=0)
    for shadow, shadows, expected in ((True, "opaque_only", 0), (False, "opaque_only", 1), (False, "attenuate", 0.36)):
        scene = make_scene(ball, {**core, "shadow": shadow}, floor, lights=[((0, 9, 3), WHITE)],
                           camera={"direction": [0, -1, 3]}, shadows=shadows)
        np.testing.assert_allclose(middle(scene, method), [expected] * 3, rtol=1e-12)


def test_F3_a_threshold_elsewhere_is_noticed():
    fails(test_F3_shadow_of_a_ball_of_glass, "exact", 0.6, "opaque_only", 1, kind=OnlyTheClearest)


# --- F4 ------------------------------------------------------------------------------------------------------------
class RangeOfEachRay(World):
    def range_of(self, ray):
        return self.max_distance


class UsesDistance(World):
    def nearest(self, ray):
        return dataclasses.replace(hit := super().nearest(ray), order=hit.t)


@BOTH
@pytest.mark.parametrize("max_distance, mirrors", [(1.9, 0), (2.1, 1), (5.9, 1), (6.3, 2), (11, 3), (33.9, 8), (40, 9)])
def test_F4_a_corridor_of_mirrors_ends_where_the_path_does(method, max_distance, mirrors, world=World):
    """Walls at z = 2 and -2 are met at 2, 6, 10, ... along the path; a lamp at the camera lights them at cos 1. Each adds
    (1 - R) R^k; behind the last one that the path reaches lies the background, as behind the eighth generation (D1)."""
    wall, background = {"reflection": 0.5}, 0.25
    walls = [thing("plane", (0, 0, z), a=0, b=0, c=-z, material=wall) for z in (2, -2)]
    scene = make_scene(*walls, lights=[((0, 0, 0), WHITE)], background=[background] * 3, max_distance=max_distance, range="path")
    expected = 1 - 0.5**mirrors + background * 0.5**mirrors
    np.testing.assert_allclose(middle(scene, method, world), [expected] * 3, rtol=1e-12)
    whole = 9 if max_distance > 4 else 1 if max_distance > 2 else 0  # each ray its own: the second would need 4
    np.testing.assert_allclose(middle(scene.traced_with(range="ray"), method), 1 - 0.5**whole * (1 - background), rtol=1e-12)


@pytest.mark.parametrize("method, max_distance, mirrors", [
    ("paper", 10.2, 2), ("paper", 10.4, 3), ("exact", 9.9, 2), ("exact", 10.2, 3)])
def test_F4_the_literal_method_uses_whole_steps(method, max_distance, mirrors, world=World):
    """The same corridor, met at 2, 6 and 10. Steps of 0.3 find its walls after 7 and 14 steps: the third ray has
    max_distance - 6.3 left of the 4 that it needs."""
    walls = [thing("plane", (0, 0, z), a=0, b=0, c=-z, material={"reflection": 0.5}) for z in (2, -2)]
    scene = make_scene(*walls, lights=[((0, 0, 0), WHITE)], max_distance=max_distance, range="path", step_size=0.3)
    np.testing.assert_allclose(middle(scene, method, world), [1 - 0.5**mirrors] * 3, rtol=1e-12)
    if method == "paper":
        np.testing.assert_allclose(literal.render(scene)[scene.camera.height // 2, scene.camera.width // 2], 1 - 0.5**mirrors)


@BOTH
@pytest.mark.parametrize("n", [1.0, 1.5])
@pytest.mark.parametrize("max_distance, seen", [(8.4, 1), (7.9, 0)])
def test_F4_refraction_shares_it_as_well(method, n, max_distance, seen):
    """Through the middle of a clear ball, met at 2 and at 4, to a wall at 8; its lamp is 3 beyond the path's end and lights it
    nevertheless: shadow rays end at their lights."""
    ball = thing("sphere", (0, 0, 3), r=1, material={"color": [0, 0, 0], "transparency": 1, "refractive_index": n})
    scene = make_scene(ball, thing("plane", (0, 0, 8), a=0, b=0, c=-1), lights=[((0, 0, -3), WHITE)],
                       max_distance=max_distance, range="path", shadows="opaque_only")
    np.testing.assert_allclose(middle(scene, method), [seen] * 3, atol=1e-12)


def test_F4_another_range_is_noticed():
    fails(test_F4_a_corridor_of_mirrors_ends_where_the_path_does, "exact", 11, 3, world=RangeOfEachRay)
    fails(test_F4_the_literal_method_uses_whole_steps, "paper", 10.2, 2, world=UsesDistance)


# --- F5 ------------------------------------------------------------------------------------------------------------
DIRECTION = (0.3, -0.4, 1)


@pytest.mark.parametrize("given, v_x, v_y", [
    ({"v_x": [2, 0, 0], "v_y": [0, 3, 0]}, (1, 0, 0), (0, 1, 0)),
    ({"v_x": [1, 1, 0], "v_y": [0, 3, 0.5]}, unit((1, 1, 0)), unit((0, 3, 0.5))),
    ({"v_x": [1, 0, 0]}, (1, 0, 0), unit(np.cross(DIRECTION, (1, 0, 0)))),
    ({"v_y": [0, 1, 0]}, unit(np.cross((0, 1, 0), DIRECTION)), (0, 1, 0)),
    ({}, unit(np.cross((0, 1, 0), DIRECTION)), np.cross(unit(DIRECTION), unit(np.cross((0, 1, 0), DIRECTION))))])
def test_F5_rays_go_by_the_axes_that_are_given(given, v_x, v_y):
    """x v_x + y v_y + v_dir, the canvas 2 tan 30 degrees wide, 5 x 3 pixels."""
    scene = make_scene(BALL, size=(5, 3), camera={"direction": DIRECTION, **given})
    x, y = (np.arange(5) - 2) / 5 * 2 * math.tan(math.pi / 6), (1 - np.arange(3)) / 5 * 2 * math.tan(math.pi / 6)
    d = unit(x[None, :, None] * np.array(v_x) + y[:, None, None] * np.array(v_y) + unit(DIRECTION))
    np.testing.assert_allclose(follow(scene)[0].d, d.reshape(-1, 3), atol=1e-15)
    angles = [np.dot(v, w) for v, w in ((v_x, v_y), (v_x, DIRECTION), (v_y, DIRECTION))]
    assert scene.camera.is_oblique == (np.abs(angles).max() > 1e-9)


def test_F5_axes_made_at_right_angles_are_noticed(monkeypatch):
    right = worlds.frame

    def wrong(camera):
        made = right(camera)
        return dataclasses.replace(made, v_y=np.cross(made.v_dir, made.v_x))

    monkeypatch.setattr(worlds, "frame", wrong)
    fails(test_F5_rays_go_by_the_axes_that_are_given, {"v_x": [2, 0, 0], "v_y": [0, 3, 0]}, (1, 0, 0), (0, 1, 0))


@pytest.mark.parametrize("given, word", [({"v_x": [0, 0, 0]}, "v_x must not be the zero vector"),
                                         ({"v_x": [1, 0, 0], "v_y": [-1, 0, 0]}, "must not lie in a plane"),
                                         ({"v_y": DIRECTION}, "must not lie in a plane"),
                                         ({"v_x": DIRECTION}, "must not lie in a plane"),
                                         ({"v_x": [-0.6, 0.8, -2]}, "must not lie in a plane"),
                                         ({"v_x": DIRECTION, "v_y": [0, 1, 0]}, "must not lie in a plane")])
def test_F5_axes_that_span_no_canvas_are_refused(given, word):
    with pytest.raises(InputError, match=word):
        make_scene(BALL, camera={"direction": DIRECTION, **given})


# --- F6 ------------------------------------------------------------------------------------------------------------
def test_F6_the_heart_s_belt_has_normals_without_specks():
    """A square about the belt, seen along z: the normal of A - y cbrt(B) by hand, all over. The printed form's gradient,
    evaluated where it is met, points anywhere: these are the figure's specks."""
    width = 2e-14
    scene = make_scene(thing("heart"), size=(21, 21), camera={
        "position": [0.3, 0, -3], "fov": math.degrees(width)})
    picture = render(scene, "exact")
    x, y, z = np.moveaxis(picture.position, -1, 0)
    root = np.cbrt(x**2 + 9 / 80 * z**2)
    expected = -unit(-np.stack([2 * x - 2 * x * y / (3 * root**2), 2 * y - root, 4.5 * z - 9 / 40 * z * y / (3 * root**2)], -1))
    assert np.all(picture.index == 0) and np.abs(y).max() < 1e-12
    np.testing.assert_allclose(picture.normal, expected, atol=1e-10)
    A = x**2 + 9 / 4 * z**2 + y**2 - 1
    printed = np.stack([6 * A**2 * x - 2 * x * y**3, 6 * A**2 * y - 3 * x**2 * y**2 - 27 / 80 * z**2 * y**2,
                        27 / 2 * A**2 * z - 9 / 40 * z * y**3], -1)
    with np.errstate(invalid="ignore"):
        off = np.linalg.norm(unit(printed) - expected, axis=-1)
    assert np.mean(~(off < 1e-3)) > 0.1


# --- all of them ---------------------------------------------------------------------------------------------------
OBLIQUE = {"direction": [0.1, -0.1, 1], "v_x": [1, 0, 0], "v_y": [0.1, 1, 0]}
SWITCHED = {
    "F1": {"lights_": "balanced"}, "F2": {"ambient": 0.2}, "F3": {"shadows": "opaque_only"},
    "F4": {"range": "path", "max_distance": 8}, "F5": {"camera": OBLIQUE},
    "all": {"lights_": "balanced", "ambient": 0.2, "shadows": "opaque_only", "range": "path", "max_distance": 8,
            "camera": OBLIQUE}}


def room(**switches) -> Scene:
    return make_scene(thing("sphere", (-0.6, 0, 4), r=1, material=GLASS), thing("sphere", (1, -0.2, 5), r=1, material=MIRROR),
                      FLOOR, **{**COMMON, **switches})


@pytest.mark.parametrize("name", SWITCHED)
@pytest.mark.parametrize("method, search", [("paper", AllSteps), ("exact", Exact)])
def test_the_wavefront_agrees_with_the_recursion(name, method, search):
    scene, plain = room(**SWITCHED[name]), room()
    expected = literal.render(scene, search(scene))
    assert np.sum(np.abs(expected - literal.render(plain, search(plain))).max(axis=-1) > 0.01) > 10
    np.testing.assert_allclose(render(scene, method).color, expected, rtol=0, atol=TOLERANCE)


def operations(scene, world=World) -> int:
    """What the kernels of a picture do, all of them together."""
    backend()
    with dr.scoped_set_flag(dr.JitFlag.KernelHistory):
        dr.kernel_history_clear()
        Renderer(scene, "exact", world=world).picture()
        return sum(kernel["operation_count"] for kernel in dr.kernel_history([dr.KernelType.JIT]))


class AlwaysAmbient(World):
    def __init__(self, scene, method, arrays):
        super().__init__(scene, method, arrays)
        self.ambient = arrays.constant(scene.tracing.ambient)


class AlwaysShared(World):
    """Every ray carries what is left of its path."""

    def camera_ray(self, *place):
        ray = super().camera_ray(*place)
        return dataclasses.replace(ray, left=self.max_distance + 0 * ray.o.x)


class AlwaysBalanced(Optics):
    """Chooses between both combinations in the kernel."""

    def combined(self, illumination, light, balanced):
        asked = dr.opaque(dr.mask_t(type(light.x)), balanced)
        return dr.select(asked, super().combined(illumination, light, True), super().combined(illumination, light, False))


@pytest.mark.parametrize("name, wrong", [("F1", with_formulas(AlwaysBalanced)), ("F2", AlwaysAmbient), ("F4", AlwaysShared)])
def test_a_kernel_holds_a_switch_only_if_the_scene_uses_it(name, wrong):
    """A tracer that records the switch for every scene records as much of a scene that does not use it as of one that does."""
    plain, switched = room(size=(8, 6)), room(**{**SWITCHED[name], "size": (8, 6), "max_distance": 12})
    assert operations(plain) < operations(switched) <= operations(plain, wrong)


def test_glass_without_shadows_is_less_work_and_axes_are_none():
    plain, size = operations(room(size=(8, 6))), {"size": (8, 6)}
    assert operations(room(**SWITCHED["F3"], **size)) < plain == operations(room(**SWITCHED["F5"], **size))
