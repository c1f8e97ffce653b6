"""The document's shading on Mitsuba's intersections: closed forms, then whole pictures against the exact reference."""

import math

import numpy as np
import pytest

from raytruth.comparisons.renderers.mitsuba import render as render_mitsuba
from raytruth.reference_tracer.scene.model import Camera, Light, Material, Object, Tracing
from raytruth.reference_tracer.surfaces import Ellipsoid, Plane, Sphere, Torus
from raytruth.reference_tracer.tracer.render import render

FLOOR = Plane(center=(0.0, -1.0, 0.0), a=0.0, b=1.0, c=0.0)
ONE_PIXEL = {"width": 1, "height": 1}


def glass(surface, n=1.4, transparency=0.8, reflection=0.0):
    return Object(surface=surface, material=Material(color=(0.9, 0.8, 0.7), transparency=transparency,
                                                     refractive_index=n, reflection=reflection))


def pixel(scene, **options):
    """The colour of a picture of one pixel, whose ray runs along the camera's direction."""
    return render_mitsuba(scene, repeat=False, **{"shapes": "native", **options}).color[0, 0]


def looking(position, direction):
    return Camera(position=position, direction=direction, up=(0.3, 0.9, 0.1), **ONE_PIXEL)


# --- closed forms ----------------------------------------------------------------------------------------------------
def test_two_lights_add_up_and_do_not_fade(scene_of):
    """One light straight above (cos 1), one 3 across and 4 up (cos 4/5), a third below the floor (no light, L2)."""
    lights = (Light(position=(0.0, 9.0, 3.0), brightness=(0.1, 0.2, 0.3)),
              Light(position=(3.0, 3.0, 3.0), brightness=(0.5, 0.0, 0.25)), Light(position=(0.0, -5.0, 3.0)))
    floor = Object(surface=FLOOR, material=Material(color=(0.5, 1.0, 0.8)))
    color = pixel(scene_of(floor, camera=looking((0.0, 0.0, 0.0), (0.0, -1.0, 3.0)), lights=lights))
    assert color == pytest.approx([0.5 * (0.1 + 0.8 * 0.5), 0.2, 0.8 * (0.3 + 0.8 * 0.25)], rel=1e-6)


@pytest.mark.parametrize("shapes", ["native", "mesh"])
@pytest.mark.parametrize("transparency, lamp, expected", [
    (0.6, 9.0, 0.6**2),  # in through one wall and out through the other: two crossings (L3)
    (0.6, 1.05, 0.6),  # the lamp hangs inside the ball: one crossing
    (0.6, 0.3, 1.0),  # the lamp hangs below the ball: the shadow ray ends there (M5)
    (0.0, 9.0, 0.0)])
def test_light_through_glass(scene_of, shapes, transparency, lamp, expected):
    """The middle of the floor under a ball of radius 1/2 around (0, 1, 3), lit from straight above."""
    scene = scene_of(FLOOR, glass(Sphere(center=(0.0, 1.0, 3.0), r=0.5), 1.7, transparency),
                     camera=looking((0.0, 0.0, 0.0), (0.0, -1.0, 3.0)), lights=(Light(position=(0.0, lamp, 3.0)),))
    assert pixel(scene, shapes=shapes, resolution=32) == pytest.approx([expected] * 3, rel=1e-5, abs=1e-7)


@pytest.mark.parametrize("depth", [0, 1, 5])
def test_a_ray_between_two_mirrors(scene_of, depth):
    """Lamp and camera in the middle: every hit is lit at cos 1. sum of (1-r) r^k, then the background with r^(D+1)."""
    r, background = 0.6, 0.25
    walls = [Object(surface=Plane(center=(0.0, 0.0, z), a=0.0, b=0.0, c=-z), material=Material(reflection=r))
             for z in (1.0, -1.0)]
    scene = scene_of(*walls, camera=looking((0.0, 0.0, 0.0), (0.0, 0.0, 1.0)), background=(background,) * 3,
                     lights=(Light(position=(0.0, 0.0, 0.0)),), tracing=Tracing(max_depth=depth))
    expected = sum((1 - r) * r**k for k in range(depth + 1)) + r ** (depth + 1) * background
    for shapes in ("native", "mesh"):
        picture = render_mitsuba(scene, shapes=shapes, repeat=False)
        assert picture.color[0, 0] == pytest.approx([expected] * 3, rel=1e-5)
        assert picture.depth[0, 0] == depth


def test_mixing_weights_at_normal_incidence(scene_of):
    """A dark room behind half-mirror glass: (c i (1-R) + R b)(1-T) + T (...), with n = 1 and a ball hit in its middle.

    The ray passes the ball straight: local colour and reflection at both walls, then the background. Lamp at the
    camera: cos 1 outside; inside, the shadow ray leaves through the near wall, so the far wall sees it with T.
    """
    R, T, b = 0.3, 0.6, 0.5
    ball = Object(surface=Sphere(center=(0.0, 0.0, 3.0), r=1.0),
                  material=Material(color=(1.0, 0.5, 0.0), reflection=R, transparency=T))
    scene = scene_of(ball, camera=looking((0.0, 0.0, 0.0), (0.0, 0.0, 1.0)), background=(b,) * 3,
                     lights=(Light(position=(0.0, 0.0, 0.0)),), tracing=Tracing(max_depth=1))
    for channel, c in enumerate((1.0, 0.5, 0.0)):
        # the far wall is of the last generation: its own rays see the background; light reaches it through one wall
        far = (c * T * (1 - R) + R * b) * (1 - T) + T * b
        assert pixel(scene)[channel] == pytest.approx((c * (1 - R) + R * b) * (1 - T) + T * far, rel=1e-5)


@pytest.mark.parametrize("n", [0.8, 1.0, 1.5])
def test_a_slab_of_glass_keeps_the_direction(scene_of, n):
    """The slab is the middle of an ellipsoid 20 wide and 1/50 thick: its walls are parallel to 4e-5 where it is hit.

    The ray leaves parallel to itself, shifted by less than 1/50 sin(6 degrees) = 2e-3, and meets a ball of radius 1
    behind; the shift turns the normal there, hence the cosine, by no more.
    """
    slab = glass(Ellipsoid(center=(0.0, 0.0, 2.0), a=10.0, b=10.0, c=0.01), n, 1.0)
    ball = Object(surface=Sphere(center=(0.5, 0.0, 5.0), r=1.0))
    parts = {"camera": looking((0.0, 0.0, 0.0), (0.1, 0.0, 1.0)), "lights": (Light(position=(-5.0, 0.0, 2.5)),)}
    bare = pixel(scene_of(ball, **parts))
    seen = render_mitsuba(scene_of(slab, ball, **parts), shapes="native", repeat=False)
    assert seen.index[0, 0] == 0 and seen.depth[0, 0] >= 2 and bare[0] > 0.3
    assert seen.color[0, 0] == pytest.approx(bare, abs=2e-3)


def test_total_internal_reflection_keeps_the_weight(scene_of):
    """n = 0.5 seen at 45 degrees, beyond asin(0.5) = 30: all of T follows the reflection (decision R3)."""
    pane = Object(surface=Plane(center=(0.0, 0.0, 3.0), a=0.0, b=0.0, c=-1.0),
                  material=Material(color=(0.0, 0.0, 0.0), transparency=0.7, refractive_index=0.5, reflection=0.4))
    wall = Object(surface=Plane(center=(8.0, 0.0, 0.0), a=-1.0, b=0.0, c=0.0))
    scene = scene_of(pane, wall, camera=looking((0.0, 0.0, 0.0), (1.0, 0.0, 1.0)),
                     lights=(Light(position=(0.0, 0.0, -2.0)),))
    # reflected at (3, 0, 3), the ray meets the wall at (8, 0, -2), which the lamp, 8 in front of it, lights with cos 1
    assert pixel(scene) == pytest.approx([0.4 * 0.3 + 0.7] * 3, rel=1e-5)


# --- whole pictures --------------------------------------------------------------------------------------------------
def mirror_and_glass(scene_of, n=1.4, **parts):
    """A mirror ball and two glass balls over a half-mirror floor, two coloured lights."""
    return scene_of(
        Object(surface=FLOOR, material=Material(color=(0.8, 0.8, 0.7), reflection=0.3)),
        Object(surface=Sphere(center=(-1.1, 0.0, 4.0), r=0.9),
               material=Material(color=(0.9, 0.3, 0.3), reflection=0.7)),
        glass(Sphere(center=(0.9, -0.2, 3.0), r=0.7), n, 0.8, 0.2), glass(Sphere(center=(0.0, -0.7, 2.0), r=0.3), n),
        width=128, height=96, background=(0.05, 0.05, 0.1),
        lights=(Light(position=(3.0, 5.0, -2.0), brightness=(0.8, 0.6, 0.5)),
                Light(position=(-4.0, 4.0, 1.0), brightness=(0.2, 0.4, 0.6))), **parts)


def differences(picture, exact):
    return np.abs(picture.color - exact.color).max(axis=-1)


def test_native_picture(scene_of):
    scene = mirror_and_glass(scene_of)
    exact, picture = render(scene, "exact"), render_mitsuba(scene, shapes="native")
    assert (picture.index == exact.index).all() and (picture.status == exact.status).all()
    assert np.quantile(differences(picture, exact), 0.99) <= 5e-6 * 2  # eight generations amplify fp32's 1e-7
    assert (differences(picture, exact) > 1 / 255).sum() <= 3
    assert (picture.depth == exact.depth).mean() > 0.999
    facts = picture.metadata
    assert facts["native_shapes"] == 4 and facts["triangles"] == 0 and facts["scene_hash"] == scene.hash
    assert 0 < facts["build"] and 0 < facts["first"]
    assert facts["warm"] is None or facts["warm"] > 0  # a picture that takes long, on a busy machine say, is made once


def test_mesh_picture_at_256(scene_of):
    scene = mirror_and_glass(scene_of)
    exact, picture = render(scene, "exact"), render_mitsuba(scene, shapes="mesh", resolution=256, repeat=False)
    assert (picture.index != exact.index).sum() <= 3
    assert np.quantile(differences(picture, exact), 0.99) <= 1e-3
    assert (differences(picture, exact) > 1 / 255).mean() < 5e-3
    assert picture.metadata["native_shapes"] == 0 and "object 0: cut to a square" in picture.metadata["clipped"]


def test_multisampled_picture(scene_of):
    """2 x 2 samples: the mean of the colours, the geometry of the pixels' centres (decision C2)."""
    scene = mirror_and_glass(scene_of, tracing=Tracing(samples=2, max_depth=2))
    exact, picture = render(scene, "exact"), render_mitsuba(scene, shapes="native", repeat=False)
    assert np.quantile(differences(picture, exact), 0.99) <= 1e-5
    one = render(mirror_and_glass(scene_of), "exact")
    near = one.t < 5  # the floor of the distance is seen at a grazing angle
    assert near.sum() > 1000 and np.quantile(np.abs(picture.t[near] - one.t[near]), 0.99) <= 5e-6


def test_bands_do_not_show(scene_of, monkeypatch):
    """Queues of 500 rays give the picture that one queue gives."""
    scene = mirror_and_glass(scene_of, tracing=Tracing(max_depth=2))
    whole = render_mitsuba(scene, shapes="native", repeat=False)
    monkeypatch.setattr("raytruth.comparisons.renderers.mitsuba.MOST_RAYS", 500)
    cut = render_mitsuba(scene, shapes="native", repeat=False)
    assert np.abs(whole.color - cut.color).max() < 1e-12 and (whole.depth == cut.depth).all()


@pytest.mark.parametrize("position", [(0.9, -0.2, 3.0), (0.0, -3.0, 0.0)], ids=["inside glass", "under the floor"])
def test_the_camera_may_stand_inside_a_solid(scene_of, position):
    """The side of a camera ray is the sign of f at the camera (decision M3)."""
    camera = Camera(position=position, direction=(-0.2, 0.3, 1.0), width=96, height=72)
    scene = mirror_and_glass(scene_of, camera=camera)
    exact, picture = render(scene, "exact"), render_mitsuba(scene, shapes="native", repeat=False)
    assert np.quantile(differences(picture, exact), 0.99) <= 2e-5


def test_overlapping_glass_keeps_a_side_for_each_object(scene_of):
    """A ray may be inside of both: leaving one is told from its own side, not from where the ray came (R1)."""
    left, right = Sphere(center=(-0.4, 0.0, 3.0), r=1.0), Sphere(center=(0.4, 0.0, 3.0), r=1.0)
    ring = Torus(center=(0.0, 0.0, 3.0), R=1.0, r=0.4)
    scene = scene_of(glass(left, 1.3), glass(right, 1.1), glass(ring, 1.2), FLOOR)
    exact, picture = render(scene, "exact"), render_mitsuba(scene, shapes="mesh", resolution=128, repeat=False)
    assert np.quantile(differences(picture, exact), 0.95) <= 2e-3
    assert np.median(differences(picture, exact)) <= 1e-4


# --- wrong on purpose ------------------------------------------------------------------------------------------------
def _wrong(scene_of, change):
    """What the comparison measures if the reference renders `change`d parameters: its 99th percentile."""
    scene = mirror_and_glass(scene_of)
    picture = render_mitsuba(scene, shapes="native", repeat=False)
    return np.quantile(differences(picture, render(change(scene), "exact")), 0.99)


def test_finds_a_wrong_refractive_index(scene_of):
    assert _wrong(scene_of, lambda scene: mirror_and_glass(scene_of, n=1.41)) > 1e-3


def test_finds_the_misprinted_law_of_refraction(scene_of):
    wrong = render(mirror_and_glass(scene_of).traced_with(refraction="as_printed"), "exact")
    picture = render_mitsuba(mirror_and_glass(scene_of), shapes="native", repeat=False)
    assert (~(differences(picture, wrong) < 1 / 255)).mean() > 0.01  # the misprint also makes NaN


def test_finds_a_missing_generation(scene_of):
    assert _wrong(scene_of, lambda scene: scene.traced_with(max_depth=2)) > 1e-2


def test_finds_a_picture_upside_down(scene_of):
    scene = mirror_and_glass(scene_of)
    exact = render(scene, "exact")
    exact.color = exact.color[::-1]
    assert np.quantile(differences(render_mitsuba(scene, shapes="native", repeat=False), exact), 0.99) > 0.1


def test_an_offset_like_mitsubas_own_would_dominate(scene_of):
    """Why rays start 1e-7 off a surface: 9e-5 costs ten times the accuracy."""
    scene = mirror_and_glass(scene_of)
    exact = render(scene, "exact")
    fine = np.quantile(differences(render_mitsuba(scene, shapes="native", repeat=False), exact), 0.99)
    coarse = np.quantile(differences(render_mitsuba(scene, shapes="native", offset=9e-5, repeat=False), exact), 0.99)
    assert math.isfinite(coarse) and coarse > 5 * fine
