"""Converted scenes: Mitsuba's intersections against closed forms and against the exact reference."""

import itertools
import math

import numpy as np
import pytest

from raytruth.comparisons.renderers.embree import render as render_embree
from raytruth.comparisons.renderers.mitsuba import render as render_mitsuba
from raytruth.converters.mitsuba import convert, pixel_directions, sensor
from raytruth.converters.mitsuba.variant import mi
from raytruth.reference_tracer.errors import InputError
from raytruth.reference_tracer.scene.model import Camera, Material, Object, Rotation, Tracing
from raytruth.reference_tracer.surfaces import Bounds, Ellipsoid, Expression, Heart, Paraboloid, Plane, Sphere, Torus
from raytruth.reference_tracer.tracer.camera import canvas_point, frame
from raytruth.reference_tracer.tracer.render import render

ASKEW = Camera(position=(0.3, 0.5, -1.0), direction=(0.1, -0.2, 1.0), up=(0.2, 1.0, 0.1), fov=50.0, width=96, height=72)


def rays(camera):
    """(h * w, 3): the camera's directions, written out from section 2."""
    f = frame(camera)
    row, col = np.mgrid[:camera.height, :camera.width]
    x, y = canvas_point(f, row.ravel(), col.ravel(), 0, 0, 1)
    d = x[:, None] * f.v_x + y[:, None] * f.v_y + f.v_dir
    return d / np.linalg.norm(d, axis=1, keepdims=True)


@pytest.mark.parametrize("radius, distance", [(1.0, 3.0), (0.1, 1.0), (5.0, 20.0)])
@pytest.mark.parametrize("inside", [False, True], ids=["from outside", "from inside"])
def test_native_sphere(scene_of, radius, distance, inside):
    """t = b -+ sqrt(b^2 - c) with b = d . (center - o) and c = |center - o|^2 - r^2."""
    center = np.array(ASKEW.position) + ([0.3 * radius, 0.1 * radius, -0.2 * radius] if inside else [0, 0, distance])
    camera = ASKEW.model_copy(update={"direction": (0.0, 0.0, 1.0)})
    scene = scene_of(Sphere(center=tuple(center.tolist()), r=radius), camera=camera)
    picture = render_mitsuba(scene, shapes="native", repeat=False)
    assert picture.metadata["native_shapes"] == 1 and picture.metadata["triangles"] == 0
    d, to_center = rays(camera).reshape(*picture.t.shape, 3), center - np.array(camera.position)
    b = d @ to_center
    with np.errstate(invalid="ignore"):
        root = np.sqrt(b * b - to_center @ to_center + radius**2)
    t = np.where(np.isnan(root), np.inf, b + root if inside else b - root)
    hit = np.isfinite(t)
    assert hit.sum() > 100 and (np.isfinite(picture.t) == hit).all()
    normal = (t[hit, None] * d[hit] - to_center) / radius * (-1 if inside else 1)  # turned against the ray (N1)
    facing = np.einsum("ij,ij->i", normal, d[hit]) < -0.2
    assert np.quantile(np.abs(picture.t[hit] - t[hit])[facing] / t[hit][facing], 0.99) <= 5e-6
    # a position is good to 1e-7 of the distance, which turns the normal of a small ball by more
    assert np.quantile(np.linalg.norm(picture.normal[hit] - normal, axis=1)[facing], 0.99) <= 5e-7 * distance / radius


@pytest.mark.parametrize("shapes", ["native", "mesh"])
def test_plane(scene_of, shapes):
    """t = (center - o) . n / (d . n), cut off at max_distance (decision M5)."""
    n, center = np.array([0.2, 1.0, -0.1]), np.array([0.0, -1.0, 0.0])
    plane = Object(surface=Plane(center=tuple(center.tolist()), a=0.2, b=1.0, c=-0.1))
    scene = scene_of(plane, camera=ASKEW, tracing=Tracing(max_distance=12.0))
    picture = render_mitsuba(scene, shapes=shapes, repeat=False)
    d = rays(ASKEW)
    with np.errstate(divide="ignore"):
        t = (center - np.array(ASKEW.position)) @ n / (d @ n)
    t = np.where((t > 0) & (t <= 12), t, np.inf).reshape(picture.t.shape)
    assert np.isinf(t).any()
    hit = np.isfinite(t)
    assert (np.isfinite(picture.t) == hit).all()
    assert np.quantile(np.abs(picture.t[hit] - t[hit]) / t[hit], 0.99) <= 5e-6
    assert np.abs(picture.normal[hit] - n / np.linalg.norm(n)).max() < 1e-6


@pytest.mark.parametrize("surface", [
    Torus(center=(0.0, 0.0, 3.5), R=0.8, r=0.3), Heart(center=(0.0, 0.0, 3.0)),
    Paraboloid(center=(0.0, -0.5, 3.0), a=0.7, b=0.9), Sphere(center=(0.0, 0.0, 3.0), r=1.0),
    Expression(center=(0.0, 0.0, 3.0), formula="x**4 + y**4 + z**4 - 1")], ids=lambda s: s.type)
def test_meshes_against_the_exact_reference(scene_of, surface):
    """Resolution 256: depth to 1e-4 away from silhouettes; a silhouette may claim a pixel."""
    turned = Object(surface=surface, rotation=Rotation(axis=(1.0, 0.2, 0.0), degrees=50.0))
    scene = scene_of(turned, width=160, height=120)
    exact = render(scene, "exact")
    picture = render_mitsuba(scene, shapes="mesh", resolution=256, repeat=False)
    both = np.isfinite(exact.t) & np.isfinite(picture.t)
    assert both.sum() > 1000 and (np.isfinite(exact.t) != np.isfinite(picture.t)).sum() <= 3
    d = rays(scene.camera).reshape(*exact.t.shape, 3)
    facing = both & (np.abs(np.einsum("...i,...i->...", exact.normal, d)) > 0.2)
    assert np.quantile(np.abs(picture.t[facing] - exact.t[facing]) / exact.t[facing], 0.99) <= 1e-4
    assert np.quantile(np.linalg.norm(picture.normal - exact.normal, axis=-1)[facing], 0.99) <= 1e-3


def test_depth_of_meshes_falls_with_the_square_of_the_resolution(scene_of):
    scene = scene_of(Torus(center=(0.0, 0.0, 3.0), R=0.8, r=0.3), width=192, height=144)
    exact = render(scene, "exact")
    facing = np.abs(np.einsum("...i,...i->...", exact.normal, rays(scene.camera).reshape(*exact.t.shape, 3))) > 0.3
    errors = []
    for resolution in (32, 64, 128, 256):
        picture = render_mitsuba(scene, shapes="mesh", resolution=resolution, repeat=False)
        seen = facing & np.isfinite(picture.t)
        errors.append(np.quantile(np.abs(picture.t[seen] - exact.t[seen]), 0.95))
    assert all(3.4 < coarse / fine < 4.6 for coarse, fine in itertools.pairwise(errors))


@pytest.mark.parametrize("camera", [ASKEW, Camera(width=50, height=80, fov=90.0)], ids=["askew", "portrait"])
def test_the_sensor_looks_along_our_rays(camera):
    assert np.abs(pixel_directions(sensor(camera)).reshape(-1, 3) - rays(camera)).max() < 1e-6


def test_a_mirrored_sensor_is_found(scene_of, monkeypatch):
    """The wrong implementation: without the scale Mitsuba's picture is mirrored left to right."""
    def mirrored(camera):
        f = frame(camera)
        return mi.load_dict({
            "type": "perspective", "fov": camera.fov, "fov_axis": "larger",
            "to_world": mi.ScalarTransform4f().look_at(origin=f.v_pos.tolist(), target=(f.v_pos + f.v_dir).tolist(),
                                                       up=f.v_y.tolist()),
            "film": {"type": "hdrfilm", "width": camera.width, "height": camera.height}})

    scene = scene_of(Sphere(center=(0.0, 0.0, 3.0), r=1.0))
    assert render_mitsuba(scene, shapes="native", repeat=False).metadata["camera_difference"] < 1e-6
    monkeypatch.setattr("raytruth.converters.mitsuba.scene.sensor", mirrored)
    assert render_mitsuba(scene, shapes="native", repeat=False).metadata["camera_difference"] > 0.1


def test_swapped_winding_is_found(scene_of, monkeypatch):
    """The wrong implementation: a mesh turned inside out offers no crossing to a ray that is outside of it."""
    from dataclasses import replace

    from raytruth.converters.mesh import mesh_object

    scene = scene_of(Sphere(center=(0.0, 0.0, 3.0), r=1.0))
    sound = render_mitsuba(scene, shapes="mesh", resolution=32, repeat=False)

    def inside_out(*arguments):
        mesh = mesh_object(*arguments)
        return replace(mesh, faces=mesh.faces[:, ::-1])

    monkeypatch.setattr("raytruth.converters.mitsuba.scene.mesh_object", inside_out)
    wrong = render_mitsuba(scene, shapes="mesh", resolution=32, repeat=False)
    front = np.isfinite(sound.t)
    assert (wrong.t[front] > sound.t[front] + 0.1)[sound.normal[front][:, 2] < -0.5].all()


def test_objects_keep_their_numbers(scene_of):
    """Native shapes and meshes side by side, in an order that is not that of their kinds."""
    objects = [Sphere(center=(-1.5, 0.0, 5.0), r=0.4), Ellipsoid(center=(-0.5, 0.0, 5.0), a=0.4, b=0.4, c=0.3),
               Torus(center=(0.5, 0.0, 5.0), R=0.3, r=0.1), Sphere(center=(1.5, 0.0, 5.0), r=0.4),
               Plane(center=(0.0, 0.0, 8.0), a=0.0, b=0.0, c=-1.0)]
    for shapes in ("native", "mesh"):
        picture = render_mitsuba(scene_of(*objects), shapes=shapes, resolution=32, repeat=False)
        exact = render(scene_of(*objects), "exact")
        assert set(np.unique(picture.index)) == {0, 1, 2, 3, 4}
        assert (picture.index != exact.index).mean() < 5e-3


def test_how_objects_were_converted(scene_of):
    scene = scene_of(Sphere(r=1.0), Ellipsoid(a=1.0, b=1.0, c=2.0), Plane(a=0.0, b=1.0, c=0.0), Heart(),
                     Plane(a=0.0, b=1.0, c=0.0, center=(0.0, 500.0, 0.0)))
    native, meshes = convert(scene, "native", 32), convert(scene, "mesh", 32)
    assert [p.kind for p in native.parts] == ["native", "mesh", "native", "mesh", "nothing"]
    assert [p.kind for p in meshes.parts] == ["mesh"] * 4 + ["nothing"]
    assert native.triangles == native.parts[1].triangles + native.parts[3].triangles > 0
    assert "square" in native.parts[2].clipped and "square" in meshes.parts[2].clipped
    fine = convert(scene_of(Torus(R=1.0, r=0.5)), "mesh", error=1e-3)
    assert fine.parts[0].error <= 1e-3
    with pytest.raises(InputError, match="native, mesh"):
        convert(scene, "meshes")


def test_no_object_within_reach(scene_of):
    background = (0.25, 0.5, 0.75)  # exact in fp32
    picture = render_mitsuba(scene_of(Sphere(center=(0.0, 0.0, -50.0), r=1.0), Plane(a=0.0, b=1.0, c=0.0, center=(
        0.0, 500.0, 0.0)), background=background), shapes="mesh", resolution=16, repeat=False)
    assert (picture.color == background).all() and np.isinf(picture.t).all() and (picture.index == -1).all()
    assert (picture.status == 0).all() and np.isnan(picture.normal).all()


def test_max_distance_ends_every_ray(scene_of):
    mirror = Object(surface=Plane(a=0.0, b=0.0, c=-1.0, center=(0.0, 0.0, 6.0)), material=Material(reflection=1.0))
    behind = Plane(a=0.0, b=0.0, c=1.0, center=(0.0, 0.0, -5.0))
    for max_distance, expected in ((10.0, 0.5), (12.0, 0.0)):  # the way from the mirror to the wall behind is 11
        picture = render_mitsuba(scene_of(mirror, behind, background=(0.5, 0.5, 0.5), width=1, height=1, lights=(),
                                          tracing=Tracing(max_distance=max_distance)), shapes="native", repeat=False)
        assert picture.color[0, 0] == pytest.approx([expected] * 3)  # the wall is unlit


def test_a_mesh_whose_error_is_not_measurable_says_so(scene_of):
    """A pole looks like a surface to a mesh; the picture's own account of it holds no number then."""
    box = Bounds(low=(-1.0,) * 3, high=(1.0,) * 3)
    jump = Expression(center=(0.0, 0.0, 4.0), formula="max(1/(x - 0.5), x**2 + y**2 + z**2 - 1)", clip=box)
    scene = scene_of(jump, Sphere(center=(2.0, 0.0, 4.0), r=0.5))
    assert [p.error is None for p in convert(scene, "mesh", 32).parts] == [True, False]
    for picture in (render_mitsuba(scene, resolution=32, repeat=False), render_mitsuba(scene, resolution=32, refined=True),
                    render_embree(scene, resolution=32)):
        assert picture.metadata["measured_mesh_error"] is None
    assert render_embree(scene_of(Sphere(r=0.5)), resolution=32).metadata["measured_mesh_error"] > 0


@pytest.mark.parametrize("settings, message", [
    ({"resolution": -5}, "at least 4 cells; found -5"), ({"error": -1.0}, "positive number; found -1.0"),
    ({"error": math.nan}, "positive number; found nan"), ({"error": 1e-3, "share": 2.0}, "not above 1; found 2.0"),
    ({"share": 0.5}, "give the error as well")])
def test_settings_that_no_mesh_can_have_are_refused_even_where_there_is_none(scene_of, settings, message):
    """The ball is a shape of Mitsuba's own."""
    with pytest.raises(InputError, match=message):
        convert(scene_of(Sphere(center=(0, 0, 3), r=1.0)), **settings)
