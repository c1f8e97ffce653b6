"""Section 2: the canvas, the pixels on it, the rays through them."""

import math

import numpy as np
import pytest
from tracing_support import make_scene, thing, unit

from raytruth.reference_tracer.scene.model import Camera
from raytruth.reference_tracer.tracer.camera import canvas_point, frame
from raytruth.reference_tracer.tracer.render import render

OBLIQUE = {"position": [0.5, -0.25, -2.0], "direction": [0.3, -0.2, 2.0], "up": [0.1, 1.0, 0.3], "fov": 75}


@pytest.mark.parametrize("fov", [1.0, 60.0, 90.0, 179.0])
@pytest.mark.parametrize("width, height", [(48, 36), (36, 48), (7, 7)])
def test_C1_the_longer_side_spans_the_field_of_view(fov, width, height):
    """span = 2 tan(pi FOV / 360), ratio = span / max(width, height); pixels are square."""
    f = frame(Camera(fov=fov, width=width, height=height))
    assert f.ratio * max(width, height) == pytest.approx(2 * math.tan(math.radians(fov / 2)), rel=1e-15)
    x0, y0 = canvas_point(f, 0, 0, 0, 0, 1)
    x1, y1 = canvas_point(f, 1, 1, 0, 0, 1)
    assert x1 - x0 == pytest.approx(f.ratio) and y1 - y0 == pytest.approx(-f.ratio)


def test_C1_row_zero_is_the_top_row_and_columns_run_to_the_right():
    """Camera at the origin, looking along +z with y up, 90 degrees, 4 x 2: ratio is 2/4, so pixel centres lie at
    x = -0.75, -0.25, 0.25, 0.75 and y = 0.25, -0.25. v_x = up x v_dir = (0,1,0) x (0,0,1) = (1,0,0)."""
    f = frame(Camera(fov=90, width=4, height=2))
    assert f.v_x.tolist() == [1, 0, 0] and f.v_y.tolist() == [0, 1, 0] and f.v_dir.tolist() == [0, 0, 1]
    picture = render(make_scene(thing("plane", (0, 0, 3), a=0, b=0, c=-1), size=(4, 2), camera={"fov": 90}))
    expected = 3 * np.array([[(x, y, 1) for x in (-0.75, -0.25, 0.25, 0.75)] for y in (0.25, -0.25)])
    np.testing.assert_allclose(picture.position, expected, rtol=1e-15, atol=1e-15)


@pytest.mark.parametrize("direction, up, right", [((0, 0, -1), (0, 1, 0), (-1, 0, 0)),
                                                  ((1, 0, 0), (0, 1, 0), (0, 0, -1)),
                                                  ((0, 1, 0), (0, 0, -1), (1, 0, 0)),
                                                  ((0, 0, 1), (0, -1, 0), (-1, 0, 0))])
def test_C1_v_x_is_up_cross_v_dir(direction, up, right):
    """The right hand of one who looks along `direction` with the head towards `up`, in the handedness of section 2."""
    assert frame(Camera(direction=tuple(map(float, direction)), up=tuple(map(float, up)))).v_x.tolist() == list(right)


def test_the_frame_is_orthonormal_and_ignores_lengths():
    f = frame(Camera(**{k: tuple(v) if isinstance(v, list) else v for k, v in OBLIQUE.items()}))
    axes = np.stack([f.v_x, f.v_y, f.v_dir])
    np.testing.assert_allclose(axes @ axes.T, np.eye(3), atol=4e-16)
    assert np.dot(f.v_y, OBLIQUE["up"]) > 0
    longer = frame(Camera(direction=(3.0, -2.0, 20.0), up=(0.2, 2.0, 0.6)))
    np.testing.assert_allclose(np.stack([longer.v_x, longer.v_y, longer.v_dir]), axes, atol=4e-16)


@pytest.mark.parametrize("size", [(9, 5), (5, 9)])
def test_every_ray_goes_from_the_camera_through_its_pixel(size):
    """r_dir = normalize(x v_x + y v_y + v_dir), r_origin = v_pos; written out here for an oblique camera.

    A sphere about the camera of radius 4 is met at v_pos + 4 r_dir, whatever the direction.
    """
    position = np.array(OBLIQUE["position"])
    scene = make_scene(thing("sphere", OBLIQUE["position"], r=4), size=size, camera=OBLIQUE)
    v_dir = unit(OBLIQUE["direction"])
    v_x = unit(np.cross(OBLIQUE["up"], v_dir))
    v_y = np.cross(v_dir, v_x)
    col, row = np.meshgrid(np.arange(size[0]), np.arange(size[1]))
    ratio = 2 * math.tan(math.pi * 75 / 360) / 9
    x, y = ratio * (col + 0.5 - size[0] / 2), ratio * (-(row + 0.5) + size[1] / 2)
    r_dir = unit(x[..., None] * v_x + y[..., None] * v_y + v_dir)
    picture = render(scene)
    np.testing.assert_allclose(picture.position, position + 4 * r_dir, atol=4e-15)
    np.testing.assert_allclose(picture.t, 4, rtol=1e-15)
    np.testing.assert_allclose(picture.normal, -r_dir, atol=2e-15)


def test_C2_samples_lie_on_a_regular_grid_of_sub_pixel_centres():
    """n = 2: the quarters of pixel (0, 0) have their centres at 1/4 and 3/4."""
    f = frame(Camera(fov=90, width=4, height=2))
    points = [canvas_point(f, 0, 0, i, j, 2) for i in (0, 1) for j in (0, 1)]
    expected = [(0.5 * (j - 2), 0.5 * (1 - i)) for i in (0.25, 0.75) for j in (0.25, 0.75)]
    np.testing.assert_allclose(points, expected, rtol=4e-16)


@pytest.mark.parametrize("n", [2, 3])
def test_C2_a_pixel_is_the_plain_mean_of_its_samples(n):
    """n x n samples of a W x H picture are the pixels of one of nW x nH: both have the same ratio / n."""
    objects = [thing("sphere", (0.2, 0.1, 4), r=1, material={"color": [1, 0.5, 0.25]}),
               thing("plane", (0, -1, 0), a=0, b=1, c=0, material={"color": [0.5, 0.5, 1]})]
    lights = [((3, 4, -1), (0.8, 0.7, 0.6))]
    width, height = 12, 8
    sampled = render(make_scene(*objects, lights=lights, size=(width, height), samples=n))
    fine = render(make_scene(*objects, lights=lights, size=(n * width, n * height)))
    mean = fine.color.reshape(height, n, width, n, 3).mean(axis=(1, 3))
    assert np.ptp(mean) > 0.5
    np.testing.assert_allclose(sampled.color, mean, atol=1e-14)
