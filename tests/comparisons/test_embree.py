"""The document's shading on Embree's intersections: closed forms, whole pictures, and the same mesh in Mitsuba."""

import sys

import numpy as np
import pytest

from raytruth.comparisons.renderers import embree, mitsuba
from raytruth.comparisons.verdicts import metrics
from raytruth.converters.embree import EmbreeIntersector, Solid, convert
from raytruth.converters.embree.crossings import Start
from raytruth.converters.mesh import mesh_object
from raytruth.reference_tracer.errors import MissingError
from raytruth.reference_tracer.scene.model import Camera, Light, Material, Object, Scene, Tracing
from raytruth.reference_tracer.surfaces import Plane, Sphere, Torus
from raytruth.reference_tracer.tracer.render import render

FLOOR = Plane(center=(0.0, -1.0, 0.0), a=0.0, b=1.0, c=0.0)


def scene_of(*things, **parts):
    objects = tuple(t if isinstance(t, Object) else Object(surface=t) for t in things)
    return Scene(objects=objects, **{"lights": (Light(position=(2.0, 3.0, -1.0)),), **parts})


def glass(surface, n=1.4, transparency=0.8, reflection=0.0):
    return Object(surface=surface, material=Material(color=(0.9, 0.8, 0.7), transparency=transparency,
                                                     refractive_index=n, reflection=reflection))


def looking(position, direction):
    return Camera(position=position, direction=direction, up=(0.3, 0.9, 0.1), width=1, height=1)


def pixel(scene, resolution=32):
    """The colour of a picture of one pixel, whose ray runs along the camera's direction."""
    return embree.render(scene, resolution=resolution).color[0, 0]


# --- closed forms ----------------------------------------------------------------------------------------------------
def test_two_lights_add_up_and_do_not_fade():
    """One light straight above (cos 1), one 3 across and 4 up (cos 4/5), a third below the floor (no light, L2)."""
    lights = (Light(position=(0.0, 9.0, 3.0), brightness=(0.1, 0.2, 0.3)),
              Light(position=(3.0, 3.0, 3.0), brightness=(0.5, 0.0, 0.25)), Light(position=(0.0, -5.0, 3.0)))
    floor = Object(surface=FLOOR, material=Material(color=(0.5, 1.0, 0.8)))
    color = pixel(scene_of(floor, camera=looking((0.0, 0.0, 0.0), (0.0, -1.0, 3.0)), lights=lights))
    assert color == pytest.approx([0.5 * (0.1 + 0.8 * 0.5), 0.2, 0.8 * (0.3 + 0.8 * 0.25)], rel=1e-12)


@pytest.mark.parametrize("transparency, lamp, expected", [
    (0.6, 9.0, 0.6**2),  # in through one wall and out through the other: two crossings (L3)
    (0.6, 1.05, 0.6),  # the lamp hangs inside the ball: one crossing
    (0.6, 0.3, 1.0),  # the lamp hangs below the ball: the shadow ray ends there (M5)
    (0.0, 9.0, 0.0)])
def test_light_through_glass(transparency, lamp, expected):
    """The middle of the floor under a ball of radius 1/2 around (0, 1, 3), lit from straight above."""
    scene = scene_of(FLOOR, glass(Sphere(center=(0.0, 1.0, 3.0), r=0.5), 1.7, transparency),
                     camera=looking((0.0, 0.0, 0.0), (0.0, -1.0, 3.0)), lights=(Light(position=(0.0, lamp, 3.0)),))
    assert pixel(scene) == pytest.approx([expected] * 3, rel=1e-12)


@pytest.mark.parametrize("depth", [0, 1, 5])
def test_a_ray_between_two_mirrors(depth):
    """Lamp and camera in the middle: every hit is lit at cos 1. sum of (1-r) r^k, then the background with r^(D+1)."""
    r, background = 0.6, 0.25
    walls = [Object(surface=Plane(center=(0.0, 0.0, z), a=0.0, b=0.0, c=-z), material=Material(reflection=r))
             for z in (1.0, -1.0)]
    scene = scene_of(*walls, camera=looking((0.0, 0.0, 0.0), (0.0, 0.0, 1.0)), background=(background,) * 3,
                     lights=(Light(position=(0.0, 0.0, 0.0)),), tracing=Tracing(max_depth=depth))
    picture = embree.render(scene, resolution=32)
    expected = sum((1 - r) * r**k for k in range(depth + 1)) + r ** (depth + 1) * background
    assert picture.color[0, 0] == pytest.approx([expected] * 3, rel=1e-12) and picture.depth[0, 0] == depth


@pytest.mark.parametrize("effects, expected", [
    (("shadow", "reflection", "refraction"), 0.4 * 0.3 + 0.7), (("shadow", "refraction"), 0.4 * 0.3 * 0.25 + 0.7),
    (("shadow", "reflection"), 0.4 * 0.3 + 0.7 * 0.25)])
def test_total_internal_reflection_keeps_the_weight(effects, expected):
    """n = 0.5 seen at 45 degrees, beyond asin(0.5) = 30: all of T follows the reflection (decision R3).

    The wall is lit with cos 1. A kind of ray that is left out sees the background.
    """
    pane = Object(surface=Plane(center=(0.0, 0.0, 3.0), a=0.0, b=0.0, c=-1.0),
                  material=Material(color=(0.0, 0.0, 0.0), transparency=0.7, refractive_index=0.5, reflection=0.4))
    wall = Object(surface=Plane(center=(8.0, 0.0, 0.0), a=-1.0, b=0.0, c=0.0))
    scene = scene_of(pane, wall, camera=looking((0.0, 0.0, 0.0), (1.0, 0.0, 1.0)), background=(0.25,) * 3,
                     lights=(Light(position=(0.0, 0.0, -2.0)),), tracing=Tracing(effects=effects))
    assert pixel(scene) == pytest.approx([expected] * 3, rel=1e-12)


@pytest.mark.parametrize("n, entering", [(1.5, True), (0.8, True), (1.5, False)])
def test_the_law_of_refraction(n, entering):
    """A ray at 30 degrees through a pane's surface into, or out of, the half-space z < 0: where it meets a far wall.

    The wall is so lit that its brightness tells the place: cos of the angle under which a lamp sees it.
    """
    z = -1.0 if entering else 1.0
    pane = Object(surface=Plane(center=(0.0, 0.0, 0.0), a=0.0, b=0.0, c=1.0),
                  material=Material(transparency=1.0, refractive_index=n))
    wall = Object(surface=Plane(center=(0.0, 0.0, 4 * z), a=0.0, b=0.0, c=-z))
    sin2 = 0.5 / n if entering else 0.5 * n
    place = 4 * sin2 / np.sqrt(1 - sin2**2)  # x on the wall
    lamp = (-1.0, 0.0, 2 * z)
    scene = scene_of(pane, wall, camera=looking((-np.tan(np.pi / 6), 0.0, -z), (0.5, 0.0, z * np.sqrt(0.75))),
                     lights=(Light(position=lamp),))
    expected = 2 / np.hypot(2, place + 1)
    assert pixel(scene) == pytest.approx([expected] * 3, rel=1e-9)


# --- crossings -------------------------------------------------------------------------------------------------------
def test_all_crossings_of_a_torus_are_counted():
    """A line through the whole ring crosses it four times, whatever side of a facet rounding puts its start on."""
    torus = glass(Torus(center=(0.0, 0.0, 0.0), R=1.0, r=0.25), transparency=0.5)
    scene = scene_of(torus)
    crossings = EmbreeIntersector(scene, convert(scene, 64))
    angle = np.linspace(0, 2 * np.pi, 200, endpoint=False)
    across = np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)
    intensity, lost = crossings.transmittance(_from(3 * across), -across, np.full(200, 6.0), np.zeros((200, 1), bool))
    assert intensity == pytest.approx(0.5**4) and not lost.any()
    # and from every first hit on, as a shadow ray leaves it: the three that are left
    hit = crossings.first_hit(_from(3 * across), -across, np.zeros((200, 1), bool), 30.0)
    start = Start(3 * across - hit.t[:, None] * across, hit.index, hit.facet)
    intensity, _ = crossings.transmittance(start, -across, np.full(200, 6.0), np.ones((200, 1), bool))
    assert intensity == pytest.approx(0.5**3)


def _from(o):
    return Start(o, np.full(len(o), -1), np.zeros(o.shape))


def test_a_missing_package_is_said_in_one_line(monkeypatch):
    monkeypatch.setitem(sys.modules, "trimesh.ray.ray_pyembree", None)  # what an import finds where it cannot be found
    scene = scene_of(Sphere(r=1.0))
    with pytest.raises(MissingError, match="pip install embreex"):
        Solid(mesh_object(scene.objects[0], scene, 16))


# --- whole pictures --------------------------------------------------------------------------------------------------
@pytest.fixture(scope="module")
def pictures():
    """A mirror ball and two glass balls over a half-mirror floor, two coloured lights: by three renderers."""
    scene = scene_of(
        Object(surface=FLOOR, material=Material(color=(0.8, 0.8, 0.7), reflection=0.3)),
        Object(surface=Sphere(center=(-1.1, 0.0, 4.0), r=0.9),
               material=Material(color=(0.9, 0.3, 0.3), reflection=0.7)),
        glass(Sphere(center=(0.9, -0.2, 3.0), r=0.7), 1.4, 0.8, 0.2), glass(Sphere(center=(0.0, -0.7, 2.0), r=0.3)),
        camera=Camera(width=128, height=96), background=(0.05, 0.05, 0.1),
        lights=(Light(position=(3.0, 5.0, -2.0), brightness=(0.8, 0.6, 0.5)),
                Light(position=(-4.0, 4.0, 1.0), brightness=(0.2, 0.4, 0.6))))
    return {"exact": render(scene, "exact"), "embree": embree.render(scene),
            "mitsuba": mitsuba.render(scene, shapes="mesh", repeat=False)}


def measured(a, b):
    planes = [{**{name: getattr(p, name) for name in ("color", "t", "position", "status", "normal", "index")},
               "camera": np.array(p.scene.camera.position)} for p in (a, b)]
    return {**metrics.geometry(*planes), **metrics.picture(*planes)}


def test_a_picture_agrees_with_the_exact_one(pictures):
    m = measured(pictures["exact"], pictures["embree"])
    assert m["interior mismatches"] == 0 and m["object mismatches"] <= 3 and m["clustered failing pixels"] == 0
    assert m["depth p99"] <= 1e-4 and m["color p99"] <= 1e-3
    assert (pictures["embree"].depth == pictures["exact"].depth).mean() > 0.999
    assert pictures["embree"].metadata["undecided pixels"] == 0


def test_on_one_mesh_two_tracers_agree_far_better_than_either_with_the_surface(pictures):
    between = measured(pictures["mitsuba"], pictures["embree"])
    for name in ("mitsuba", "embree"):
        apart = measured(pictures["exact"], pictures[name])
        for number in ("depth p99", "color p99", "normal p99 degrees"):
            assert between[number] < apart[number] / 5, (name, number)
    assert between["depth p99"] < 1e-6 and between["color p99"] < 5e-5 and between["object mismatches"] == 0


def test_several_samples_are_the_mean_of_finer_pixels(pictures):
    scene = pictures["embree"].scene.resized(32, 24)
    coarse = embree.render(scene.resized(32, 24, samples=2), resolution=32)
    fine = embree.render(scene.resized(64, 48), resolution=32).color
    assert coarse.color == pytest.approx(fine.reshape(24, 2, 32, 2, 3).mean(axis=(1, 3)), abs=1e-12)
    assert coarse.t == pytest.approx(embree.render(scene, resolution=32).t)
