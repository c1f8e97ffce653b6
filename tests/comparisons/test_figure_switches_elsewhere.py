"""Switches F1 to F5, and objects without shadows, in Mitsuba's and Embree's renderers: closed forms, then pictures."""

import math
from functools import partial

import numpy as np
import pytest

from raytruth.comparisons.renderers import embree, mitsuba
from raytruth.converters.mitsuba import convert, document_directions, sensor
from raytruth.converters.mitsuba.dressed import dressed
from raytruth.reference_tracer.errors import UnsupportedError
from raytruth.reference_tracer.scene.model import Camera, Light, Material, Object, Scene, Tracing
from raytruth.reference_tracer.surfaces import Plane, Sphere
from raytruth.reference_tracer.tracer.render import UNDECIDED, render

MAKE = {"mitsuba": partial(mitsuba.render, shapes="native", repeat=False), "embree": partial(embree.render, resolution=32)}
EXACT = {"mitsuba": 2e-6, "embree": 1e-12}  # of planes
FLOOR = Plane(center=(0.0, -1.0, 0.0), a=0.0, b=1.0, c=0.0)
ONE = {"width": 1, "height": 1}
DOWN = Camera(direction=(0.0, -1.0, 3.0), **ONE)
by_both = pytest.mark.parametrize("who", MAKE)


def scene_of(*objects, lights=((0.0, 9.0, 3.0),), camera=DOWN, background=(0.0, 0.0, 0.0), **tracing) -> Scene:
    return Scene(objects=objects, camera=camera, background=background, tracing=Tracing(**tracing),
                 lights=tuple(light if isinstance(light, Light) else Light(position=light) for light in lights))


def thing(surface, shadow=True, **material):
    return Object(surface=surface, shadow=shadow, material=Material(**material))


def pixel(who, scene):
    return MAKE[who](scene).color[0, 0]


@by_both
@pytest.mark.parametrize("lights, ambient, expected", [
    ("balanced", 0.0, 1 - 0.4 * 0.6), ("sum", 0.25, 0.25 + 0.6 + 0.4), ("balanced", 0.25, 1 - 0.75 * 0.4 * 0.6)])
def test_lights_and_ambient_light_combine(who, lights, ambient, expected):
    """The floor at (0, -1, 3): a lamp of 0.6 straight above, one of 0.5 at cos 4/5, one below the floor (L2)."""
    lamps = (Light(position=(0.0, 9.0, 3.0), brightness=(0.6,) * 3), Light(position=(3.0, 3.0, 3.0), brightness=(0.5,) * 3),
             Light(position=(0.0, -5.0, 3.0)))
    scene = scene_of(thing(FLOOR, color=(0.5, 1.0, 0.8)), lights=lamps).traced_with(lights=lights, ambient=ambient)
    assert pixel(who, scene) == pytest.approx(expected * np.array([0.5, 1.0, 0.8]), rel=EXACT[who])


@by_both
@pytest.mark.parametrize("transparency, shadow, shadows, expected", [
    (0.6, True, "attenuate", 0.36), (0.6, True, "opaque_only", 1.0), (0.0, True, "opaque_only", 0.0),
    (0.6, False, "attenuate", 1.0), (0.0, False, "attenuate", 1.0)])
def test_shadows_of_a_ball(who, transparency, shadow, shadows, expected):
    ball = thing(Sphere(center=(0.0, 1.0, 3.0), r=0.5), shadow, transparency=transparency, refractive_index=1.7)
    scene = scene_of(thing(FLOOR), ball, shadows=shadows)
    assert pixel(who, scene) == pytest.approx([expected] * 3, rel=1e-6)


@by_both
@pytest.mark.parametrize("max_distance, mirrors", [(1.9, 0), (5.9, 1), (6.1, 2), (11.0, 3), (40.0, 9)])
def test_a_range_is_shared_along_a_path(who, max_distance, mirrors):
    """A corridor of mirrors, met at 2, 6, 10, ...: see tests/reference_tracer/test_figure_switches.py."""
    walls = [thing(Plane(center=(0.0, 0.0, z), a=0.0, b=0.0, c=-z), reflection=0.5) for z in (2.0, -2.0)]
    scene = scene_of(*walls, lights=((0.0, 0.0, 0.0),), camera=Camera(**ONE), background=(0.25,) * 3,
                     max_distance=max_distance, range="path")
    assert pixel(who, scene) == pytest.approx([1 - 0.75 * 0.5**mirrors] * 3, rel=1e-5)


OBLIQUE = Camera(direction=(0.1, -0.1, 1.0), v_x=(1.0, 0.0, 0.0), v_y=(0.1, 1.0, 0.0), width=96, height=72)


@by_both
def test_rays_go_by_axes_that_are_not_at_right_angles(who):
    """A wall at z = 5: where x v_x + y v_y + v_dir meets it."""
    scene = scene_of(thing(Plane(center=(0.0, 0.0, 5.0), a=0.0, b=0.0, c=-1.0)), camera=OBLIQUE)
    picture, step = MAKE[who](scene), 2 * math.tan(math.pi / 6) / 96
    x, y = step * (np.arange(96) - 47.5)[None, :, None], step * (35.5 - np.arange(72))[:, None, None]
    v_dir, v_y = np.array((0.1, -0.1, 1.0)) / np.sqrt(1.02), np.array((0.1, 1.0, 0.0)) / np.sqrt(1.01)
    d = x * np.array((1.0, 0.0, 0.0)) + y * v_y + v_dir
    np.testing.assert_allclose(picture.position, 5 * d / d[..., 2:], atol=2e-6)


def test_mitsuba_has_no_such_camera_and_says_so():
    with pytest.raises(UnsupportedError, match="F5"):
        sensor(OBLIQUE)
    scene = scene_of(thing(FLOOR), camera=OBLIQUE)
    assert convert(scene).sensor is None and MAKE["mitsuba"](scene).metadata["camera_difference"] is None
    upright = OBLIQUE.model_copy(update={"v_x": None, "v_y": None})
    assert np.abs(document_directions(upright) - document_directions(OBLIQUE)).max() > 0.05
    assert MAKE["mitsuba"](scene_of(thing(FLOOR), camera=upright)).metadata["camera_difference"] < 1e-6


@pytest.mark.parametrize("changes", [{"lights": "balanced"}, {"ambient": 0.1}, {"shadows": "opaque_only"}, {"range": "path"}])
def test_mitsuba_s_own_light_transport_refuses_them(changes):
    bare = Scene(objects=(thing(FLOOR),))
    dressed(bare, lambda obj: {})
    with pytest.raises(UnsupportedError, match=next(iter(changes))):
        dressed(bare.traced_with(**changes), lambda obj: {})
    with pytest.raises(UnsupportedError, match="object 0 must not"):
        dressed(Scene(objects=(thing(FLOOR, shadow=False),)), lambda obj: {})


# --- whole pictures --------------------------------------------------------------------------------------------------
ROOM = Scene(
    objects=(thing(FLOOR, color=(0.8, 0.8, 0.7), reflection=0.3),
             thing(Sphere(center=(-1.1, 0.0, 4.0), r=0.9), color=(0.9, 0.3, 0.3), reflection=0.7),
             thing(Sphere(center=(0.9, -0.2, 3.0), r=0.7), color=(0.9, 0.8, 0.7), transparency=0.8, reflection=0.2,
                   refractive_index=1.4)),
    camera=Camera(width=96, height=72), background=(0.05, 0.05, 0.1),
    lights=(Light(position=(3.0, 5.0, -2.0), brightness=(0.8, 0.6, 0.5)),
            Light(position=(-4.0, 4.0, 1.0), brightness=(0.6, 0.7, 0.6))))
SWITCHED = {
    "F1": ROOM.traced_with(lights="balanced"), "F2": ROOM.traced_with(ambient=0.2),
    "F3": ROOM.traced_with(shadows="opaque_only"), "F4": ROOM.traced_with(range="path", max_distance=12.0),
    "F5": ROOM.model_copy(update={"camera": OBLIQUE}),
    "no shadow": ROOM.model_copy(update={"objects": (ROOM.objects[0], *(
        o.model_copy(update={"shadow": False}) for o in ROOM.objects[1:]))})}


@pytest.mark.parametrize("name", SWITCHED)
@pytest.mark.parametrize("who, share, limit", [("mitsuba", 0.99, 2e-6), ("embree", 0.95, 5e-3)])
def test_a_picture_agrees_with_the_exact_one_and_not_with_the_text_s(name, who, share, limit):
    """Mitsuba has exact shapes of all of this; Embree's balls are of facets, 32 across."""
    scene = SWITCHED[name]
    exact, text, picture = render(scene, "exact"), render(ROOM, "exact"), MAKE[who](scene)
    off = lambda of: np.quantile(np.abs(picture.color - of.color).max(axis=-1)[of.status != UNDECIDED], share)
    assert off(exact) <= limit
    assert np.mean(np.abs(picture.color - text.color).max(axis=-1) > 2e-2) > 0.02
