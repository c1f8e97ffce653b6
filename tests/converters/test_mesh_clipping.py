"""Unbounded surfaces are cut to what rays can reach, and never nearer."""

import math

import numpy as np
import pytest

from raytruth.converters.mesh import check
from raytruth.converters.povray import convert as convert_to_povray
from raytruth.reference_tracer.scene.model import Camera, Light, Material, Object, Rotation, Tracing
from raytruth.reference_tracer.scene.placement import reach
from raytruth.reference_tracer.surfaces import Bounds, Expression, Paraboloid, Plane, Sphere

FLOOR = Plane(center=(0.0, -1.0, 0.0), a=0.0, b=1.0, c=0.0)
MIRROR = Material(reflection=0.5)


def test_reach_of_camera_rays(scene_of):
    """Nothing reflects: a ray ends max_distance from the camera; shadow rays end at their lights."""
    scene = scene_of(FLOOR, camera=Camera(position=(1.0, 2.0, 3.0)), lights=(Light(position=(0.0, 50.0, 0.0)),),
                     tracing=Tracing(max_distance=10.0))
    assert reach(scene) == pytest.approx(np.array([[-9, -8, -7], [11, 50, 13]]))


def test_reach_beyond_a_bounded_mirror(scene_of):
    """A reflected ray starts on the ball, whose box is [19, 21] along x, and runs 10 from there at most."""
    scene = scene_of(FLOOR, Object(surface=Sphere(center=(20.0, 0.0, 0.0), r=1.0), material=MIRROR),
                     tracing=Tracing(max_distance=10.0))
    assert reach(scene)[1] == pytest.approx([31, 11, 11])


def test_reach_between_unbounded_mirrors(scene_of):
    """Two facing mirrors carry a ray on by max_distance in each generation; depth 3 makes four such rays in a line."""
    walls = [Object(surface=Plane(center=(0.0, 0.0, z), a=0.0, b=0.0, c=-z), material=MIRROR) for z in (1.0, -1.0)]
    scene = scene_of(*walls, tracing=Tracing(max_distance=10.0, max_depth=3))
    assert reach(scene)[1, 0] == pytest.approx(40)
    flat = scene.traced_with(max_depth=0)
    assert reach(flat)[1, 0] == pytest.approx(10)


def test_a_plane_covers_its_part_of_the_reach(mesh_of, scene_of):
    parts = {"tracing": Tracing(max_distance=10.0)}
    tilted = Plane(center=(0.0, -1.0, 0.0), a=1.0, b=2.0, c=-0.5)
    mesh = mesh_of(tilted, **parts)
    normal = np.array([1.0, 2.0, -0.5]) / math.sqrt(5.25)
    assert np.abs((mesh.vertices - [0, -1, 0]) @ normal).max() < 1e-12
    assert np.allclose(mesh.normals, normal)
    a, b, c = mesh.vertices[mesh.faces.T]
    facets = np.cross(b - a, c - a)
    assert (facets @ normal > 0).all()  # outward winding
    # every point of the plane within 10 of the camera lies in the square: the mesh must hold that whole disc
    sides = mesh.vertices - mesh.vertices.mean(axis=0)
    half = 0.5 * math.sqrt(0.5 * np.linalg.norm(facets, axis=1).sum())
    assert half == pytest.approx(math.sqrt(300), rel=1e-9)  # half the diagonal of the cube of side 20
    assert np.abs(sides).max() <= half * math.sqrt(2) + 1e-9
    foot = -(2.0 / math.sqrt(5.25)) * normal  # of the camera, on the plane
    assert np.linalg.norm(mesh.vertices.mean(axis=0) - foot) < 1e-9 and "square" in mesh.clipped and not mesh.closed


def test_a_paraboloid_is_cut_above_the_reach(mesh_of):
    """z up to 10 - 3 in its frame: below a height H lies the volume pi a b H^2 / 2, which the cap at H closes."""
    mesh = mesh_of(Paraboloid(a=1.0, b=0.5, center=(0.0, 0.0, 3.0)), 256, tracing=Tracing(max_distance=10.0))
    x, y, z = (mesh.vertices - [0, 0, 3]).T
    height = z.max()
    assert height == pytest.approx(7, rel=1e-12)
    assert np.abs(x**2 + y**2 / 0.25 - z).max() < 1e-13
    # seen from the apex the cap is a cone of volume pi a b H H / 3; the rest is the mesh's share, outward positive
    a, b, c = (mesh.vertices - [0, 0, 3])[mesh.faces.T]
    share = np.einsum("ij,ij->i", np.cross(a, b), c).sum() / 6
    assert share == pytest.approx(math.pi * 0.5 * 49 * (1 / 2 - 1 / 3), rel=1e-3)
    assert (np.einsum("ij,ij->i", np.cross(b - a, c - a), mesh.normals[mesh.faces[:, 0]]) > 0).all()
    assert "above its apex" in mesh.clipped


def test_a_turned_paraboloid_is_cut_in_its_own_frame(mesh_of):
    """A half turn about x: it opens along -z and the reach ends at z = -10, 13 below the apex."""
    mesh = mesh_of(Object(surface=Paraboloid(a=1.0, b=1.0, center=(0.0, 0.0, 3.0)),
                          rotation=Rotation(axis=(1.0, 0.0, 0.0), degrees=180.0)), tracing=Tracing(max_distance=10.0))
    assert mesh.vertices[:, 2].min() == pytest.approx(-10) and mesh.vertices[:, 2].max() == pytest.approx(3)


@pytest.mark.parametrize("surface", [
    Plane(center=(0.0, -50.0, 0.0), a=0.0, b=1.0, c=0.0), Paraboloid(a=1.0, b=1.0, center=(0.0, 0.0, 11.0)),
    Expression(formula="x**2 + y**2 + (z - 40)**2 - 1"), Expression(formula="x**2 + y**2 + z**2 + 1")],
    ids=["plane", "paraboloid", "ball out of reach", "nothing at all"])
def test_what_no_ray_reaches_is_left_out(mesh_of, surface):
    mesh = mesh_of(surface, tracing=Tracing(max_distance=10.0))
    assert mesh.triangles == 0 and "left out" in mesh.clipped


def test_an_expression_without_bounds_is_found(mesh_of):
    """x^4 + y^4 + z^4 = 1 somewhere in a reach of side 60: interval arithmetic finds its box, side 2, and closes it."""
    mesh = mesh_of(Expression(formula="x**4 + y**4 + z**4 - 1"))
    found = check(mesh)
    assert found.watertight and found.euler_number == 2
    assert abs(found.volume - 8 * math.gamma(1.25) ** 3 / math.gamma(1.75)) < found.area * mesh.error


def test_an_unbounded_cylinder_is_cut(mesh_of):
    """x^2 + y^2 = 1 within |z| <= 10: area 2 pi 20, two rims, so vertices - edges + faces = 0."""
    mesh = mesh_of(Expression(formula="x**2 + y**2 - 1"), 256, tracing=Tracing(max_distance=10.0))
    found = check(mesh)
    assert not found.watertight and found.consistent and found.euler_number == 0 and not found.faults(mesh)
    length = np.ptp(mesh.vertices[:, 2])
    assert length >= 20 and found.area == pytest.approx(2 * math.pi * length, rel=3e-3)


def test_bounds_that_are_not_proven_are_a_mesh_s_region_and_no_more(mesh_of, scene_of):
    """f is not defined behind the camera, so that no proof reaches everywhere; the ball is meshed where it is promised."""
    box = Bounds(low=(-1.0,) * 3, high=(1.0,) * 3)
    ball = Expression(center=(0.0, 0.0, 4.0), formula="x**2 + y**2 + z**2 - 1 + 0*sqrt(z + 20)", bounds=box)
    mesh = mesh_of(ball)
    assert check(mesh).watertight and not mesh.closed and mesh.clipped == "bounds not proven"
    assert abs(check(mesh).volume - 4 / 3 * math.pi) < check(mesh).area * mesh.error
    proven = mesh_of(Expression(formula="x**2 + y**2 + z**2 - 1", bounds=box))
    assert proven.closed and proven.clipped == ""
    assert "bounds not proven" in convert_to_povray(scene_of(ball)).remark
    mirror = scene_of(Object(surface=ball, material=MIRROR), tracing=Tracing(max_distance=10.0, max_depth=3))
    assert reach(mirror)[1, 0] == pytest.approx(40)  # as if it could be met anywhere
