"""Section 4.3.3: the law of refraction, total internal reflection, and the rays that follow from them."""

import numpy as np
import pytest
from tracing_support import follow, make_scene, thing, unit

from raytruth.reference_tracer.backend import backend
from raytruth.reference_tracer.tracer.optics import reflect, refract
from raytruth.reference_tracer.tracer.render import render

METHODS = ("paper", "exact")
SIZE = (9, 7)


def refracted(angle, n1, n2, **options):
    """Directions (n, 3) and whether they are total reflections, for rays that meet the plane z = 0 from above."""
    arrays = backend()
    angle = np.atleast_1d(np.asarray(angle, float))
    d = np.stack([np.sin(angle), 0 * angle, -np.cos(angle)])
    number = lambda v: arrays.Float(np.ascontiguousarray(np.broadcast_to(v, angle.shape), float))
    found = refract(arrays.Vector(*map(number, d)), arrays.Vector(0, 0, 1), number(np.cos(angle)), number(n1),
                    number(n2), **options)
    return found.direction.numpy().T, np.broadcast_to(found.total.numpy(), angle.shape)


@pytest.mark.parametrize("n1, n2", [(1, 1.5), (1.5, 1), (1, 0.8), (0.8, 1), (1, 1), (1, 10)])
def test_snell_s_law(n1, n2):
    """sin1 / sin2 = n2 / n1, in the plane of incidence, on the far side, of unit length."""
    angle = np.linspace(0, 0.999, 50) * np.arcsin(min(1, n2 / n1))
    d, total = refracted(angle, n1, n2)
    assert not total.any() and np.all(d[:, 2] < 0)
    np.testing.assert_allclose(d[:, 0], np.sin(angle) * n1 / n2, atol=4e-16)
    np.testing.assert_allclose(np.linalg.norm(d, axis=1), 1, rtol=1e-14)
    assert np.all(d[:, 1] == 0)


def test_snell_s_law_about_any_normal():
    """n1 d1 x N = n2 d2 x N: the vector form of the law."""
    random = np.random.default_rng(1)
    arrays = backend()
    normal, d = unit(random.normal(size=(100, 3))), unit(random.normal(size=(100, 3)))
    normal *= -np.sign(np.sum(normal * d, axis=1, keepdims=True))
    vector = lambda v: arrays.Vector(*(arrays.Float(np.ascontiguousarray(c)) for c in v.T))
    cos1 = -np.sum(normal * d, axis=1)
    found = refract(vector(d), vector(normal), arrays.Float(cos1), arrays.Float(1),
                    arrays.Float(1.4)).direction.numpy().T
    np.testing.assert_allclose(1.4 * np.cross(found, normal), np.cross(d, normal), atol=1e-15)
    mirror = reflect(vector(d), vector(normal), arrays.Float(cos1)).numpy().T
    np.testing.assert_allclose(np.cross(mirror, normal), np.cross(d, normal), atol=1e-15)
    np.testing.assert_allclose(np.sum(mirror * normal, axis=1), cos1, atol=1e-15)


@pytest.mark.parametrize("n1, n2", [(1.5, 1), (1, 0.8), (1.0001, 1)])
def test_total_reflection_begins_at_the_critical_angle(n1, n2):
    critical = np.arcsin(n2 / n1)
    _, total = refracted(critical * np.array([1 - 1e-9, 1 + 1e-9]), n1, n2)
    assert total.tolist() == [False, True]


def test_R2_at_the_critical_angle_itself_it_refracts():
    """sin1 = n2/n1 without rounding: n = 1 at grazing incidence (cos1 = 0, sin1 = 1), which goes straight on; and
    n1 = 1.25, n2 = 1, cos1 = 0.6, for which 1 - 0.6^2 = 0.64 and 1/1.25 = 0.8 come out equal in double precision."""
    assert np.sqrt(1 - 0.6 * 0.6) == 0.8 == 1 / 1.25
    arrays = backend()
    along = refract(arrays.Vector(1, 0, 0), arrays.Vector(0, 0, 1), arrays.Float([0, 0]), arrays.Float(1),
                    arrays.Float(1))
    assert not along.total.numpy().any() and along.direction.numpy()[:, 0].tolist() == [1, 0, 0]
    critical = refract(arrays.Vector(0.8, 0, -0.6), arrays.Vector(0, 0, 1), arrays.Float([0.6, 0.6]),
                       arrays.Float(1.25), arrays.Float(1))
    assert not critical.total.numpy().any()
    np.testing.assert_allclose(critical.direction.numpy()[:, 0], [1, 0, 0], atol=2e-8)


def test_E1_the_printed_sine_is_a_misprint():
    """n = 1.5 at 30 degrees. Snell: sin2 = 1/3, 19.47 degrees. As printed sin2 = 0.75: the direction
    (1/3, 0, -sqrt(1 - 0.75^2)) has length 0.7407 and leans 26.74 degrees; from asin(1/1.5) = 41.8 degrees on NaN."""
    direction, _ = refracted(np.radians(30), 1, 1.5)
    np.testing.assert_allclose(direction[0], [1 / 3, 0, -np.sqrt(8) / 3], rtol=1e-15)
    printed, total = refracted(np.radians([30, 41, 42]), 1, 1.5, as_printed=True)
    np.testing.assert_allclose(printed[0], [1 / 3, 0, -np.sqrt(1 - 0.75**2)], rtol=1e-15)
    assert np.linalg.norm(printed[0]) == pytest.approx(0.7407, abs=1e-4)
    assert np.degrees(np.arctan2(printed[0, 0], -printed[0, 2])) == pytest.approx(26.74, abs=0.01)
    assert np.isfinite(printed[1]).all() and np.isnan(printed[2, 2]) and not total.any()


# --- paths through bodies ------------------------------------------------------------------------------------------
def slab(z, half, n, **material) -> dict:
    """Glass between z - half and z + half: f = (z - z0)^2 - half^2."""
    return thing("expression", (0, 0, z), formula=f"z**2 - {half**2}",
                 material={"color": [0, 0, 0], "transparency": 1, "refractive_index": n, **material})


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("n", [0.95, 1.0, 1.5])
def test_a_slab_shifts_rays_and_does_not_turn_them(n, method):
    """Exit direction = entry direction; the shift between the two parallel lines is e sin(th1 - th2) / cos(th2) for a
    slab of thickness e = 1 (any textbook on optics), 0 for n = 1."""
    camera, inside, after = follow(make_scene(slab(3, 0.5, n), size=SIZE, camera={"fov": 80}), method)
    assert len(after.pixel) == len(camera.pixel) == 63
    np.testing.assert_allclose(after.d, camera.d, atol=4e-15)
    th1 = np.arccos(camera.d[:, 2])
    th2 = np.arcsin(np.sin(th1) / n)
    np.testing.assert_allclose(inside.d[:, 2], np.cos(th2), atol=1e-14)
    shift = np.linalg.norm(np.cross(after.o - camera.o, camera.d), axis=1)
    np.testing.assert_allclose(shift, np.abs(np.sin(th1 - th2) / np.cos(th2)), atol=1e-13)
    assert n == 1 or shift.max() > 0.02


@pytest.mark.parametrize("method", METHODS)
def test_M3_a_ball_turns_rays_twice_by_the_same_angle(method):
    """A ray that meets a ball at impact parameter b leaves it turned by 2 (th1 - th2), sin th1 = b / r, sin th2 =
    sin th1 / n, and 2 r cos th2 beyond its entry. Both ends of the path inside lie on the surface: a ray that took its
    side from f there, or an epsilon, would end early or late."""
    camera, inside, after = follow(make_scene(
        thing("sphere", (0, 0, 4), r=1, material={"transparency": 1, "refractive_index": 1.5}), size=(24, 18),
        camera={"fov": 35}, step_size=0.03), method)
    first = camera.d[np.isin(camera.pixel, after.pixel)]
    assert 100 < len(after.pixel) == len(inside.pixel) == len(first)
    b = np.linalg.norm(np.cross([0, 0, 4], first), axis=1)
    th1, th2 = np.arcsin(b), np.arcsin(b / 1.5)
    chord = np.linalg.norm(after.o - inside.o, axis=1)
    np.testing.assert_allclose(chord, 2 * np.cos(th2), atol=1e-12)
    np.testing.assert_allclose(np.sum(first * after.d, axis=1), np.cos(2 * (th1 - th2)), atol=1e-12)


@pytest.mark.parametrize("method", METHODS)
def test_normal_incidence_goes_straight_on(method):
    camera, inside, after = follow(make_scene(slab(3, 0.5, 1.7)), method)
    assert inside.d.tolist() == after.d.tolist() == camera.d.tolist() == [[0, 0, 1]]
    ball = thing("sphere", (0, 0, 4), r=1, material={"transparency": 1, "refractive_index": 1.7})
    camera, inside, after = follow(make_scene(ball), method)
    np.testing.assert_allclose(after.d, [[0, 0, 1]], atol=1e-15)


@pytest.mark.parametrize("method", METHODS)
def test_R1_every_medium_is_paired_with_air(method):
    """A slab n = 1.3 within a slab n = 1.5. Entering the inner one divides the sine by 1.3, leaving it multiplies by
    1.3, whatever surrounds it: sines 1, 1/1.5, 1/(1.5*1.3), 1/1.5, 1. Between media it would be 1/1.3 in the middle."""
    generations = follow(make_scene(slab(4, 1, 1.5), slab(4, 0.5, 1.3), size=SIZE, camera={"fov": 80}), method)
    assert [len(g.pixel) for g in generations] == [63] * 5
    sine = np.sqrt(1 - generations[0].d[:, 2]**2)
    for generation, index in zip(generations, (1, 1.5, 1.5 * 1.3, 1.5, 1)):
        np.testing.assert_allclose(np.hypot(generation.d[:, 0], generation.d[:, 1]), sine / index, atol=1e-14)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("n, inside", [(1.5, True), (0.7, False)])
def test_under_water_the_critical_angle_divides_the_picture(n, inside, method):
    """The camera in a half-space of glass (n = 1.5) looks at its surface, or from air at a half-space of n = 0.7: from
    sin1 > 1/1.5, or 0.7, the secondary ray is the mirrored one, else Snell's. Every pixel is held against the
    formula."""
    glass = thing("plane", (0, 0, 2), a=0, b=0, c=1 if inside else -1,
                  material={"transparency": 1, "refractive_index": n})
    camera, after = follow(make_scene(glass, size=(17, 13), camera={"fov": 110}, max_distance=60), method)[:2]
    ratio = n if inside else 1 / n  # n1 / n2
    sine = np.hypot(camera.d[:, 0], camera.d[:, 1])
    total = sine > 1 / ratio
    assert 30 < total.sum() < 200 and np.array_equal(after.pixel, camera.pixel)
    expected = np.where(total[:, None], camera.d * [1, 1, -1],
                        np.stack([camera.d[:, 0] * ratio, camera.d[:, 1] * ratio,
                                  np.sqrt(np.maximum(1 - (sine * ratio)**2, 0))], axis=1))
    np.testing.assert_allclose(after.d, expected, atol=4e-15)


@pytest.mark.parametrize("method", METHODS)
def test_R3_total_reflection_keeps_the_weight_of_refraction(method):
    """45 degrees in glass n = 1.5 (critical: 41.8): one ray, of weight R (1 - T) + T, sees the background; the surface
    itself, lit from the camera's place (cos phi = 1/sqrt(2)), has (1 - R)(1 - T)."""
    R, T = 0.3, 0.6
    glass = thing("plane", (0, 2, 0), a=0, b=1, c=0,
                  material={"color": [1, 0, 0], "reflection": R, "transparency": T, "refractive_index": 1.5})
    scene = make_scene(glass, camera={"direction": [0, 1, 1]}, lights=[((0, 0, 0), (1, 1, 1))], background=(0, 0.5, 0))
    generations = follow(scene, method)
    assert [len(g.pixel) for g in generations] == [1, 1]
    assert generations[1].weight == pytest.approx(R * (1 - T) + T, rel=1e-15)
    np.testing.assert_allclose(generations[1].d, unit([[0, -1, 1]]), atol=1e-15)
    expected = [(1 - R) * (1 - T) / np.sqrt(2), 0.5 * (R * (1 - T) + T), 0]
    np.testing.assert_allclose(render(scene, method).color[0, 0], expected, rtol=1e-13)
    # of a surface that does not reflect otherwise the weight is T
    alone = glass | {"material": glass["material"] | {"reflection": 0}}
    assert follow(make_scene(alone, camera={"direction": [0, 1, 1]}), method)[1].weight == pytest.approx(T, rel=1e-15)


WALL = thing("plane", (0, 0, 7), a=0, b=0.2, c=-1, material={"color": [0.9, 0.6, 0.3]})


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("T", [1.0, 0.8])
def test_glass_of_index_one_is_seen_by_its_weights_only(T, method):
    """A black ball of n = 1 before a wall, lit from the camera's place: whatever is seen through the ball is also lit
    through it, two crossings each way, so the picture is T^4 of the one without."""
    camera = {"size": (24, 18), "camera": {"fov": 40}, "lights": [((0, 0, 0), (1, 1, 1))], "step_size": 0.05}
    ball = thing("sphere", (0, 0, 4), r=1, material={"color": [0, 0, 0], "transparency": T, "refractive_index": 1})
    without, behind = render(make_scene(WALL, **camera), method), render(make_scene(WALL, ball, **camera), method)
    through = behind.index == 1
    assert 50 < through.sum() < 300
    np.testing.assert_allclose(behind.color, without.color * np.where(through, T**4, 1)[..., None], atol=1e-12)


@pytest.mark.parametrize("method", METHODS)
def test_E1_scenes_refract_by_snell_unless_they_ask_for_the_misprint(method):
    """sin 30 degrees = 1/2 becomes 1/3 in glass of 1.5; as printed the direction is (1/3, sqrt(1 - 0.75^2))."""
    glass = thing("plane", (0, 0, 2), a=0, b=0, c=-1, material={"transparency": 1, "refractive_index": 1.5})
    camera = {"direction": [0, 1, np.sqrt(3)]}
    for parameters, tangent in (({}, 1 / np.sqrt(8)), ({"refraction": "as_printed"}, 1 / 3 / np.sqrt(1 - 0.75**2))):
        d = follow(make_scene(glass, camera=camera, **parameters), method)[1].d[0]
        assert d[1] / d[2] == pytest.approx(tangent, rel=1e-14)
