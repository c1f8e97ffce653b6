"""Section 4.3.1, 4.3.2 and 4.3.4: light, shadow, mirrors and how they mix, each against its formula."""

import numpy as np
import pytest
from tracing_support import make_scene, thing, unit

from raytruth.reference_tracer.tracer.render import render

METHODS = ("paper", "exact")
GREY = {"color": [0.8, 0.6, 0.4]}
FLOOR = thing("plane", (0, -1, 0), a=0, b=1, c=0, material=GREY)
CAMERA = {"direction": [0, -0.5, 1]}
SIZE = (16, 12)


def pixel(*objects, method="exact", **scene) -> np.ndarray:
    """The colour of a picture of one pixel, whose ray is the camera's direction itself."""
    return render(make_scene(*objects, **scene), method).color[0, 0]


@pytest.mark.parametrize("method", METHODS)
def test_illumination_is_cosine_times_brightness(method):
    """color * max(cos phi, 0) * brightness on a floor; cos phi = height of the light / distance to it."""
    light, brightness = np.array([1.0, 2.0, 4.0]), np.array([0.9, 0.5, 0.25])
    picture = render(make_scene(FLOOR, lights=[(light, brightness)], size=SIZE, camera=CAMERA, max_distance=12), method)
    hit = picture.index == 0
    assert 0.3 < hit.mean() < 1
    to_light = light - picture.position
    cos = 3 / np.linalg.norm(to_light, axis=-1, keepdims=True)
    expected = np.where(hit[..., None], np.array(GREY["color"]) * brightness * cos, 0)
    np.testing.assert_allclose(picture.color, expected, atol=1e-12)


@pytest.mark.parametrize("method", METHODS)
def test_the_cosine_is_taken_with_the_surface_s_normal(method):
    """On a ball the normal is (p - c)/r; the side away from the light is black (its own shadow, and L2)."""
    center, light = np.array([0.2, -0.1, 4.0]), np.array([3.0, 3.0, 0.0])
    picture = render(make_scene(thing("sphere", center, r=1.2, material=GREY), lights=[(light, (1, 1, 1))], size=SIZE,
                                camera={"fov": 40}), method)
    hit = picture.index == 0
    normal = (picture.position - center) / 1.2
    cos = np.sum(normal * unit(light - picture.position), axis=-1, keepdims=True)
    assert hit.sum() > 40 and 5 < (cos[hit] < 0).sum()
    np.testing.assert_allclose(picture.normal[hit], normal[hit], atol=1e-12)
    np.testing.assert_allclose(picture.color[hit], np.array(GREY["color"]) * np.maximum(cos[hit], 0), atol=1e-12)


@pytest.mark.parametrize("method", METHODS)
def test_L1_lights_add_up_by_channel_and_do_not_fall_off(method):
    """Floor at distance 1 below, lights overhead (cos = 1) at heights 2 and 20: red from one, green and blue from the
    other. With 1/r^2 the second would be 1/400."""
    color = pixel(FLOOR, camera={"direction": [0, -1, 0], "up": [0, 0, 1]}, method=method,
                  lights=[((0, 1, 0), (0.5, 0.25, 0)), ((0, 19, 0), (0, 0.125, 2))])
    np.testing.assert_allclose(color, [0.8 * 0.5, 0.6 * 0.375, 0.4 * 2], rtol=1e-14)


@pytest.mark.parametrize("method", METHODS)
def test_L2_a_light_behind_the_surface_adds_nothing(method):
    """Camera above the floor, light below it: cos phi = -1, which must not be subtracted from the other light's 1. The
    floor is half transparent (n = 1, nothing beneath), so that the light from below does arrive: by the half it loses
    the floor's own colour weighs 1 - T = 1/2."""
    floor = FLOOR | {"material": GREY | {"transparency": 0.5}}
    down = {"direction": [0, -1, 0], "up": [0, 0, 1]}
    color = pixel(floor, camera=down, lights=[((0, -3, 0), (1, 1, 1)), ((0, 2, 0), (0.5, 0.5, 0.5))], method=method)
    np.testing.assert_allclose(color, 0.5 * 0.5 * np.array(GREY["color"]), rtol=1e-14)
    for below in (floor, FLOOR):
        assert pixel(below, camera=down, lights=[((0, -3, 0), (1, 1, 1))], method=method).tolist() == [0, 0, 0]


def test_a_scene_without_a_light_shows_its_background_and_nothing_else():
    scene = make_scene(FLOOR, size=(4, 6), background=(0.1, 0.2, 0.3))
    picture = render(scene.model_copy(update={"lights": ()}))
    assert {tuple(c) for c in picture.color.reshape(-1, 3)} == {(0, 0, 0), (0.1, 0.2, 0.3)}


def _shadowed(blocker: dict, method: str) -> float:
    """The floor straight below the camera, lit from (2, 3, 0) above; `blocker` stands on the way, in nobody's sight."""
    color = pixel(FLOOR, blocker, lights=[((2, 3, 0), (1, 1, 1))], method=method,
                  camera={"direction": [0, -1, 0], "up": [0, 0, 1]}, step_size=0.05)
    return color[0] / (0.8 * 4 / np.sqrt(20))  # cos phi = 4/sqrt(20)


GLASS = {"color": [0, 0, 0], "transparency": 0.7, "refractive_index": 1.5}


@pytest.mark.parametrize("method", METHODS)
def test_L3_light_is_weakened_at_every_crossing(method):
    """One crossing of a half-space: T. In and out of a ball: T^2. Of a torus along its axis plane: T^4. Opaque: 0.

    The shadow ray runs from (0, -1, 0) to (2, 3, 0), through (1, 1, 0).
    """
    assert _shadowed(thing("sphere", (1, 1, 0), r=0.4, material=GLASS), method) == pytest.approx(0.7**2, rel=1e-13)
    half_space = thing("plane", (0, 1.5, 0), a=0, b=-1, c=0, material=GLASS)
    assert _shadowed(half_space, method) == pytest.approx(0.7, rel=1e-13)
    torus = thing("torus", (1, 1, 0), R=0.7, r=0.2, material=GLASS)
    assert _shadowed(torus, method) == pytest.approx(0.7**4, rel=1e-13)
    assert _shadowed(thing("sphere", (1, 1, 0), r=0.4), method) == 0
    assert _shadowed(thing("sphere", (5, 1, 0), r=0.4), method) == pytest.approx(1, rel=1e-13)


@pytest.mark.parametrize("method", METHODS)
def test_L3_the_attenuations_of_several_objects_multiply(method):
    """Two balls, T = 0.7 and 0.5, one after the other: 0.49 * 0.25."""
    other = thing("sphere", (1.5, 2, 0), r=0.3, material=GLASS | {"transparency": 0.5})
    color = pixel(FLOOR, thing("sphere", (0.6, 0.2, 0), r=0.3, material=GLASS), other, lights=[((2, 3, 0), (1, 1, 1))],
                  camera={"direction": [0, -1, 0], "up": [0, 0, 1]}, method=method, step_size=0.05)
    assert color[0] == pytest.approx(0.8 * 4 / np.sqrt(20) * 0.49 * 0.25, rel=1e-13)


@pytest.mark.parametrize("method", METHODS)
def test_M5_a_shadow_ray_ends_at_its_light(method):
    """A ball beyond the light casts no shadow, and one that holds the light casts one crossing's."""
    assert _shadowed(thing("sphere", (3, 5, 0), r=0.4), method) == pytest.approx(1, rel=1e-13)
    assert _shadowed(thing("sphere", (2, 3, 0), r=0.4, material=GLASS), method) == pytest.approx(0.7, rel=1e-13)


# --- mirrors -------------------------------------------------------------------------------------------------------
def _mirrors(reflection: float, **parameters) -> dict:
    """Two facing mirrors at z = 2 (red) and z = -2 (green), camera and light between them, looking along +z."""
    material = lambda color: {"color": color, "reflection": reflection}
    return dict(zip(("front", "back"), (thing("plane", (0, 0, 2), a=0, b=0, c=-1, material=material([1, 0, 0])),
                                        thing("plane", (0, 0, -2), a=0, b=0, c=1, material=material([0, 1, 0])))))


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("r, depth", [(0.5, 0), (0.5, 1), (0.5, 7), (0.9, 8), (0.9, 40), (1.0, 5)])
def test_D1_a_mirror_box_is_a_geometric_series(r, depth, method):
    """The ray runs to and fro along z at normal incidence, cos phi = 1 at every meeting: the k-th one (k = 0, 1, ...,
    max_depth) adds r^k (1 - r) of the mirror's colour, red for even k, green for odd; then the background adds
    r^(depth+1). Light and camera stand on the axis, at z = 0.
    """
    mirrors = _mirrors(r)
    color = pixel(mirrors["front"], mirrors["back"], lights=[((0, 0, 0), (1, 1, 1))], background=(0, 0, 0.5),
                  method=method,
                  max_depth=depth)
    term = (1 - r) * r**np.arange(depth + 1)
    np.testing.assert_allclose(color, [term[::2].sum(), term[1::2].sum(), 0.5 * r**(depth + 1)], rtol=1e-13, atol=1e-16)


@pytest.mark.parametrize("method", METHODS)
def test_D1_the_depth_plane_counts_generations(method):
    mirrors = _mirrors(0.5)
    for depth in (0, 3):
        picture = render(make_scene(mirrors["front"], mirrors["back"], lights=[((0, 0, 0), (1, 1, 1))],
                                    max_depth=depth), method)
        assert picture.depth.tolist() == [[depth]] and picture.metadata["rays"] >= depth + 1
    alone = make_scene(mirrors["front"], lights=[((0, 0, 0), (1, 1, 1))], max_depth=5)
    assert render(alone, method).depth.tolist() == [[1]]  # the reflection meets nothing and ends


@pytest.mark.parametrize("method", METHODS)
def test_reflection_obeys_the_mirror_law(method):
    """A floor that mirrors (R = 1) shows what a camera below it, looking up, would see without it: the image of a lit
    ball. The mirrored scene: y -> -y about the floor y = -1, for camera, ball and light alike."""
    ball = thing("sphere", (0.3, 0.5, 5), r=1, material=GREY)
    lights = [((-3, 4, 1), (1, 1, 1))]
    mirrored = render(make_scene(ball, FLOOR | {"material": {"reflection": 1}}, lights=lights, size=SIZE,
                                 camera=CAMERA), method)
    seen = mirrored.index == 1
    alone = render(make_scene(ball, lights=lights, size=SIZE,
                              camera={"position": [0, -2, 0], "direction": [0, 0.5, 1]}), method)
    flipped = alone.color[::-1]
    assert flipped[seen].max() > 0.3
    np.testing.assert_allclose(mirrored.color[seen], flipped[seen], atol=1e-11)


# --- section 4.3.4 -------------------------------------------------------------------------------------------------
@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("R, T", [(0.0, 0.0), (0.3, 0.0), (1.0, 0.0), (0.0, 0.6), (0.3, 0.6), (0.3, 1.0), (1.0, 1.0)])
def test_the_three_rays_are_mixed_with_the_printed_weights(R, T, method):
    """pointColor = (visible (1 - R) + R reflected)(1 - T) + T refracted. A pane (half-space z > 2, n = 1) at normal
    incidence: it is lit by 0.5 from the camera's place; behind the camera stands a wall lit by 0.8 * 0.5 = 0.4 green,
    and within the half-space one lit through the pane, 0.5 T blue."""
    pane = thing("plane", (0, 0, 2), a=0, b=0, c=-1, material={"color": [1, 0, 0], "reflection": R, "transparency": T})
    behind = thing("plane", (0, 0, -3), a=0, b=0, c=1, material={"color": [0, 0.8, 0]})
    beyond = thing("plane", (0, 0, 6), a=0, b=0, c=-1, material={"color": [0, 0, 1]})
    color = pixel(pane, behind, beyond, lights=[((0, 0, 0), (0.5, 0.5, 0.5))], method=method)
    visible, reflected, refracted = np.array([0.5, 0, 0]), np.array([0, 0.4, 0]), np.array([0, 0, 0.5 * T])
    np.testing.assert_allclose(color, (visible * (1 - R) + R * reflected) * (1 - T) + T * refracted, rtol=1e-13,
                               atol=1e-16)


@pytest.mark.parametrize("method", METHODS)
def test_D2_rays_that_hit_nothing_see_the_background(method):
    """Directly, in a mirror (R = 0.4), through glass (T = 0.7), with the weights of 4.3.4; black by default."""
    sky = np.array([0.2, 0.4, 0.8])
    ahead = lambda **material: thing("plane", (0, 0, 2), a=0, b=0, c=-1, material={"color": [0, 0, 0], **material})
    np.testing.assert_allclose(pixel(ahead(reflection=0.4), background=sky, method=method), 0.4 * sky, rtol=1e-15)
    np.testing.assert_allclose(pixel(ahead(transparency=0.7), background=sky, method=method), 0.7 * sky, rtol=1e-15)
    up = {"direction": [0, 0, -1]}
    assert pixel(ahead(), background=sky, camera=up, method=method).tolist() == sky.tolist()
    assert make_scene(ahead()).background == (0, 0, 0)
