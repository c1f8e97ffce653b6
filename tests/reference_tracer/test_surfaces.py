"""Section 7.1: the printed equations, their signs, their boxes, and their rotation."""

import math
from fractions import Fraction

import numpy as np
import pytest
from closed_forms import into_frame
from tracing_support import make_scene, thing, unit

from raytruth.reference_tracer.numbers import Dual, OutwardInterval
from raytruth.reference_tracer.scene.placement import is_inside, rotation_matrix
from raytruth.reference_tracer.surfaces import Ellipsoid, Heart, Paraboloid, Plane, Sphere, Torus

SURFACES = {
    "plane": Plane(a=1.0, b=-2.0, c=0.5), "sphere": Sphere(r=1.5), "ellipsoid": Ellipsoid(a=0.5, b=2.0, c=1.25),
    "torus": Torus(R=2.0, r=0.5), "spindle": Torus(R=0.5, r=1.0), "paraboloid": Paraboloid(a=0.75, b=1.5),
    "heart": Heart()}
# the equations as section 7.1 prints them, with x0 = y0 = z0 = 0 and the signs of decision O2
PRINTED = {
    "plane": lambda x, y, z: x * 1 + y * -2 + z * 0.5,
    "sphere": lambda x, y, z: x**2 + y**2 + z**2 - 1.5**2,
    "ellipsoid": lambda x, y, z: x**2 / 0.5**2 + y**2 / 2**2 + z**2 / 1.25**2 - 1,
    "torus": lambda x, y, z: (np.sqrt(x**2 + y**2) - 2)**2 + z**2 - 0.5**2,
    "spindle": lambda x, y, z: (np.sqrt(x**2 + y**2) - 0.5)**2 + z**2 - 1**2,
    "paraboloid": lambda x, y, z: x**2 / 0.75**2 + y**2 / 1.5**2 - z,
    "heart": lambda x, y, z: (x**2 + 9 / 4 * z**2 + y**2 - 1)**3 - x**2 * y**3 - 9 / 80 * z**2 * y**3}


@pytest.mark.parametrize("name", SURFACES)
def test_the_equation_is_the_printed_one(name):
    points = np.random.default_rng(1).uniform(-2, 2, (3, 200))
    np.testing.assert_allclose(SURFACES[name](*points), PRINTED[name](*points), rtol=1e-13, atol=1e-13)


@pytest.mark.parametrize("name", SURFACES)
def test_the_regular_form_has_the_signs_of_f(name):
    """Only the heart's differs from f; away from rounding (|f| > 1e-13) the signs agree."""
    points = np.random.default_rng(2).uniform(-1.5, 1.5, (3, 20_000))
    f, g = SURFACES[name](*points), SURFACES[name].regular(*points)
    clear = np.abs(f) > 1e-13
    assert clear.mean() > 0.99 and np.array_equal(f[clear] < 0, g[clear] < 0)


def test_O2_planes_and_paraboloids_are_half_open_solids():
    """Plane: inside is behind, where a(x-x0) + b(y-y0) + c(z-z0) < 0. Paraboloid: inside is the bowl above its tip."""
    plane, bowl = Plane(a=0.0, b=1.0, c=0.0), Paraboloid(a=1.0, b=1.0)
    assert plane(5.0, -1.0, 5.0) < 0 < plane(5.0, 1.0, 5.0)
    assert bowl(0.0, 0.0, 1.0) < 0 < bowl(0.0, 0.0, -1.0) and bowl(2.0, 0.0, 3.9) > 0 > bowl(2.0, 0.0, 4.1)


def test_O1_zero_is_outside_and_the_flip_is_the_surface_s():
    sphere = make_scene(thing("sphere", (0, 0, 0), r=1), thing("sphere", (0, 0, 0), r=1, inside="positive"))
    for point, expected in (((0, 0, 0.5), [True, False]), ((0, 0, 1), [False, False]), ((0, 0, 1.5), [False, True])):
        assert [is_inside(o, point) for o in sphere.objects] == expected


def test_O4_the_torus_has_no_inner_sheet():
    """R = 0.5, r = 1. The polynomial form (x^2+y^2+z^2+R^2-r^2)^2 - 4R^2(x^2+y^2) changes sign once more, within
    rho < r - R = 0.5; the printed form is negative throughout, up to rho = R + r = 1.5."""
    rho = np.linspace(0, 2, 2001)
    inside = SURFACES["spindle"](rho, 0 * rho, 0 * rho) < 0
    assert np.array_equal(inside, rho < 1.5 - 1e-12)
    polynomial = (rho**2 + 0.5**2 - 1)**2 - 4 * 0.5**2 * rho**2
    assert not np.array_equal(polynomial < 0, rho < 1.5 - 1e-12)


def test_O4_the_torus_has_no_gradient_on_its_axis():
    with np.errstate(all="ignore"):
        gradient = SURFACES["spindle"](*Dual.axes((np.array([0.0]), np.array([0.0]), np.array([0.9]))))
        assert not np.isfinite(gradient.derivative(0)).any()


def test_O5_the_heart_s_constant_is_nine_eightieths():
    """On x = 0 the surface is (9/4 z^2 + y^2 - 1)^3 = 9/80 z^2 y^3. With z^2 = 80/9 s^3 the right side is (s y)^3, so
    y^2 - s y + 20 s^3 - 1 = 0: s = 1/10 gives y = (0.1 + sqrt(0.01 + 3.92)) / 2."""
    s = 0.1
    y, z = (s + math.sqrt(s**2 + 4 * (1 - 20 * s**3))) / 2, math.sqrt(80 / 9 * s**3)
    assert abs(Heart.f_regular(0.0, y, z)) < 4e-16 and abs(Heart.f(0.0, y, z)) < 1e-16
    # f(0, 1, 2) = 9^3 - 9/80 * 4 and f(1, 1, 1) = (13/4)^3 - 1 - 9/80, in rational arithmetic
    assert Heart.f(0.0, 1.0, 2.0) == float(729 - Fraction(36, 80))
    assert Heart.f(1.0, 1.0, 1.0) == float(Fraction(13, 4)**3 - 1 - Fraction(9, 80))


def test_O5_the_regular_form_keeps_a_gradient_on_the_singular_ellipse():
    """On y = 0, x^2 + 9/4 z^2 = 1, grad f = 0, while grad(A - y cbrt(B)) = (2x, -cbrt(B), 9/2 z)."""
    angle = np.linspace(0.1, 6, 20)
    x, y, z = np.cos(angle), 0 * angle, 2 / 3 * np.sin(angle)
    f, g = (form(*Dual.axes((x, y, z))) for form in (Heart.f, Heart.f_regular))
    gradient = lambda value: np.stack([np.broadcast_to(value.derivative(k), 20) for k in range(3)])
    assert np.abs(gradient(f)).max() < 1e-15
    np.testing.assert_allclose(gradient(g), [2 * x, -np.cbrt(x**2 + 9 / 80 * z**2), 4.5 * z], atol=1e-15)


EXTREMES = {  # where the surface reaches farthest along x, y and z
    "sphere": [(1.5, 0, 0), (0, 1.5, 0), (0, 0, 1.5)], "ellipsoid": [(0.5, 0, 0), (0, 2, 0), (0, 0, 1.25)],
    "torus": [(2.5, 0, 0), (0, 2.5, 0), (2, 0, 0.5)], "spindle": [(1.5, 0, 0), (0, 1.5, 0), (0.5, 0, 1)]}


@pytest.mark.parametrize("name", EXTREMES)
def test_boxes_hold_the_surface_and_touch_it(name):
    """f >= 0 at points outside of the box; the surface touches the box at its extreme points."""
    surface = SURFACES[name]
    low, high = map(np.array, surface.box())
    points = np.random.default_rng(3).uniform(-2, 2, (20_000, 3)) * high
    outside = points[np.any((points < low) | (points > high), axis=1)]
    assert np.all(surface(*outside.T) >= 0) and len(outside) > 1000
    for k, extreme in enumerate(EXTREMES[name]):
        assert surface(*extreme) == 0 and extreme[k] == high[k] == -low[k]


def test_nothing_of_the_heart_lies_outside_of_its_box():
    """Proof. With |y| cbrt(B) <= r^(5/3) and A >= r^2 - 1 the regular form exceeds r^2 - 1 - r^(5/3) > 0 from r = 2.2
    on. The rest of [-2.2, 2.2]^3 outside of the box is divided into cells until outward-rounded intervals exclude
    zero."""
    assert 2.2**2 - 1 - 2.2**(5 / 3) > 0
    low, high = map(np.array, Heart().box())
    cells = np.array([[[-2.2, 2.2]] * 3])
    for k in range(3):  # cut along the planes of the box, and drop the box itself
        cuts = np.array([[-2.2, low[k]], [low[k], high[k]], [high[k], 2.2]])
        cells = np.repeat(cells[:, None], 3, axis=1)
        cells[:, :, k] = cuts
        cells = cells.reshape(-1, 3, 2)
    middle = cells.mean(axis=-1)
    cells = cells[np.any((middle < low) | (middle > high), axis=-1)]
    assert len(cells) == 26
    for _ in range(40):
        g = Heart.f_regular(*(OutwardInterval(cells[:, k, 0], cells[:, k, 1]) for k in range(3)))
        cells = cells[~(g.low > 0)]
        if not len(cells):
            break
        longest = np.argmax(cells[..., 1] - cells[..., 0], axis=-1)
        row, middle = np.arange(len(cells)), cells[np.arange(len(cells)), longest].mean(axis=-1)
        lower, upper = cells.copy(), cells.copy()
        lower[row, longest, 1], upper[row, longest, 0] = middle, middle
        cells = np.concatenate([lower, upper])
    assert not len(cells)


def test_O3_a_rotation_turns_about_its_axis_by_the_right_hand():
    """90 degrees about z take x to y; 120 degrees about (1,1,1) take x to y, y to z, z to x (the columns)."""
    scene = make_scene(thing("sphere", r=1, rotation={"axis": [0, 0, 2], "degrees": 90}),
                       thing("sphere", r=1, rotation={"axis": [1, 1, 1], "degrees": 120}),
                       thing("sphere", r=1, rotation={"axis": [0, 1, 0], "degrees": -450}))
    quarter, third, wound = (rotation_matrix(o.rotation) for o in scene.objects)
    assert quarter.tolist() == [[0, -1, 0], [1, 0, 0], [0, 0, 1]]
    np.testing.assert_allclose(third, [[0, 0, 1], [1, 0, 0], [0, 1, 0]], atol=4e-16)
    assert wound.tolist() == [[0, 0, -1], [0, 1, 0], [1, 0, 0]]
    assert np.array_equal(rotation_matrix(None), np.eye(3))


@pytest.mark.parametrize("axis, degrees", [((1, 2, -0.5), 33), ((0, 0, 1), 180), ((-1, 0, 0.25), 271.5)])
def test_O3_rotations_agree_with_an_independent_implementation(axis, degrees):
    scene = make_scene(thing("sphere", r=1, rotation={"axis": axis, "degrees": degrees}))
    v = unit(np.random.default_rng(4).normal(size=(10, 3)))
    local, _ = into_frame(scene.objects[0], v, v)
    np.testing.assert_allclose(v @ rotation_matrix(scene.objects[0].rotation), local, atol=1e-15)
