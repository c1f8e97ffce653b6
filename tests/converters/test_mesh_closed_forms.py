"""Meshes against closed forms of area, volume, topology and normals."""

import math

import numpy as np
import pytest

from raytruth.converters.mesh import check, convert
from raytruth.converters.mesh.marching import BRICK, Grid
from raytruth.converters.mesh.placed import Placed
from raytruth.reference_tracer.scene.model import Camera, Material, Object, Rotation, Scene, Tracing
from raytruth.reference_tracer.surfaces import Ellipsoid, Expression, Heart, Plane, Sphere, Torus
from raytruth.reference_tracer.surfaces.expression import Bounds

CUBE = Bounds(low=(-1.0, -1.0, -1.0), high=(1.0, 1.0, 1.0))
SPHERE = Sphere(center=(0.4, -0.2, 3.0), r=1.25)
TORUS = Torus(center=(1.0, 2.0, 3.0), R=0.8, r=0.3)
ELLIPSOID = Ellipsoid(a=1.0, b=0.5, c=0.7)
DISC = Ellipsoid(a=10.0, b=10.0, c=0.01)  # thinner than a cubic cell
SUPERQUADRIC = Expression(formula="x**4 + y**4 + z**4 - 1", bounds=CUBE)
OCTAHEDRON = Expression(formula="abs(x) + abs(y) + abs(z) - 1", bounds=CUBE)

# Volumes: ball, torus by Pappus, ellipsoid; x^4 + y^4 + z^4 <= 1 by Dirichlet's integral; an octahedron of edge sqrt 2.
VOLUMES = [(SPHERE, 4 / 3 * math.pi * 1.25**3, 2), (TORUS, 2 * math.pi**2 * 0.8 * 0.3**2, 0),
           (ELLIPSOID, 4 / 3 * math.pi * 1.0 * 0.5 * 0.7, 2), (DISC, 4 / 3 * math.pi * 100.0 * 0.01, 2),
           (SUPERQUADRIC, 8 * math.gamma(1.25) ** 3 / math.gamma(1.75), 2), (OCTAHEDRON, 4 / 3, 2)]


@pytest.mark.parametrize("surface, volume, euler", VOLUMES, ids=lambda v: getattr(v, "type", None))
@pytest.mark.parametrize("rotation", [None, Rotation(axis=(1.0, 2.0, 3.0), degrees=40.0)], ids=["upright", "turned"])
def test_encloses_the_volume(mesh_of, surface, volume, euler, rotation):
    mesh = mesh_of(Object(surface=surface, rotation=rotation))
    found = check(mesh)
    assert found.watertight and found.consistent and found.finite and not found.faults(mesh)
    assert found.euler_number == euler
    # triangles within `error` of the surface enclose a volume that differs by at most area * error; positive: outward
    assert abs(found.volume - volume) <= found.area * mesh.error
    assert mesh.residual <= 1e-14


@pytest.mark.parametrize("surface, area", [
    (SPHERE, 4 * math.pi * 1.25**2), (TORUS, 4 * math.pi**2 * 0.8 * 0.3), (OCTAHEDRON, 4 * math.sqrt(3))],
    ids=lambda v: getattr(v, "type", None))
def test_has_the_area(mesh_of, surface, area):
    coarse, fine = (check(mesh_of(surface, n)).area for n in (32, 64))
    assert abs(fine - area) < 0.55 * abs(coarse - area)  # a smooth surface: 1/4; the octahedron's cut-off edges: 1/2
    assert abs(fine / area - 1) < (2e-2 if surface is OCTAHEDRON else 1e-3)


def test_a_room_winds_into_the_room(mesh_of):
    """inside = "positive": the solid is everything around the ball, so outward is towards the centre."""
    mesh = mesh_of(Sphere(r=1.0, inside="positive"))
    assert check(mesh).volume == pytest.approx(-4 / 3 * math.pi, rel=2e-3)
    assert np.allclose(mesh.normals, -mesh.vertices, atol=1e-12)


def test_vertices_and_normals_of_a_turned_torus(mesh_of):
    """The closed form in the torus's own frame: a quarter turn about x takes its axis z to -y."""
    mesh = mesh_of(Object(surface=TORUS, rotation=Rotation(axis=(1.0, 0.0, 0.0), degrees=90.0)))
    p = mesh.vertices - np.array([1.0, 2.0, 3.0])
    x, y, z = p[:, 0], p[:, 2], -p[:, 1]
    to_ring = 1 - 0.8 / np.hypot(x, y)  # the outward normal is p minus the nearest point of the ring
    normal = np.stack([x * to_ring, -z, y * to_ring], axis=1) / 0.3
    assert np.abs(np.linalg.norm(normal, axis=1) - 1).max() < 1e-13
    assert np.abs(mesh.normals - normal).max() < 1e-13


def _facet_deviation(mesh, chosen):
    """The largest angle, in degrees, between vertex normals and facets at the chosen vertices; slivers do not count."""
    a, b, c = mesh.vertices[mesh.faces.T]
    facets = np.cross(b - a, c - a)
    doubled_area = np.linalg.norm(facets, axis=1)
    kept = chosen[mesh.faces[:, 0]] & (doubled_area > 1e-7)
    assert kept.sum() > 500
    cosine = np.einsum("ij,ij->i", facets, mesh.normals[mesh.faces[:, 0]])[kept] / doubled_area[kept]
    return math.degrees(math.acos(cosine.min()))


def test_normals_of_the_heart(mesh_of):
    """Off the belt y = 0 they are the printed form's, differentiated by hand; on it they agree with the facets."""
    mesh = mesh_of(Heart(), 128)
    x, y, z = mesh.vertices.T
    a = x**2 + 2.25 * z**2 + y**2 - 1
    printed = np.stack([6 * x * a**2 - 2 * x * y**3,
                        6 * y * a**2 - 3 * y**2 * (x**2 + 9 / 80 * z**2),
                        13.5 * z * a**2 - 9 / 40 * z * y**3], axis=1)
    printed /= np.linalg.norm(printed, axis=1, keepdims=True)
    away = (np.abs(y) > 0.2) & (np.hypot(x, z) > 0.1)  # also off the two tips
    assert np.abs(mesh.normals - printed)[away].max() < 1e-13
    # cells of 1/55 on a surface of curvature about 3 turn by less than 4 degrees
    assert _facet_deviation(mesh, np.abs(y) < 5e-3) < 4


def test_the_printed_form_of_the_heart_fails_on_the_belt(mesh_of, monkeypatch):
    """The wrong implementation: its gradient vanishes there, so that Newton and normals go astray (decision O5)."""
    monkeypatch.setattr(Heart, "regular_form", property(lambda self: self.function))
    mesh = mesh_of(Heart(), 128)
    x, y, z = mesh.vertices.T
    assert np.abs(Heart.f_regular(x, y, z)).max() > 1e-3
    assert _facet_deviation(mesh, np.abs(y) < 5e-3) > 20


def test_the_spindle_torus_has_no_inner_sheet(mesh_of):
    """r > R: the square-root form describes the outer sheet alone (decision O4), one closed surface like a sphere."""
    found = check(mesh_of(Torus(R=0.5, r=0.7)))
    assert found.watertight and found.euler_number == 2


def test_bricks_give_what_one_volume_gives():
    """Independent computation: marching cubes over the whole grid at once, projected radially."""
    from skimage.measure import marching_cubes

    from raytruth.converters.mesh.marching import march

    placed = Placed(Object(surface=SPHERE))
    vertices, faces, cell = march(placed, placed.box, 3 * BRICK)
    grid = Grid.over(placed.box, 3 * BRICK)
    assert len(grid.bricks(placed)) < 4**3  # corners and middle hold no surface
    axes = [grid.low[k] + np.arange(n + 1) * cell[k] for k, n in enumerate(grid.counts)]
    x, y, z = np.ix_(*axes)
    whole, triangles, _, _ = marching_cubes(x**2 + y**2 + z**2 - 1.25**2, 0.0, gradient_direction="descent")
    assert (len(vertices), len(faces)) == (len(whole), len(triangles))
    assert abs(np.sort(np.linalg.norm(vertices, axis=1)) - np.sort(
        np.linalg.norm(grid.low + whole * cell, axis=1))).max() < 1e-5 * 1.25  # skimage computes in fp32


def test_wrong_meshes_are_found(mesh_of):
    """Swapped winding, a missing triangle and vertices off the surface do not pass for a sound mesh."""
    from dataclasses import replace

    mesh = mesh_of(SPHERE)
    assert check(replace(mesh, faces=mesh.faces[:, ::-1])).volume < 0
    torn = check(replace(mesh, faces=mesh.faces[1:]))
    assert torn.faults(mesh) == ["is not watertight, though its surface is bounded"]
    turned = mesh.faces.copy()
    turned[0] = turned[0, ::-1]
    assert "has neighbouring triangles that run opposite ways" in check(replace(mesh, faces=turned)).faults(mesh)
    broken = mesh.normals.copy()
    broken[0] = np.nan
    assert check(replace(mesh, normals=broken)).faults(mesh) == ["has vertices or normals that are not finite"]
    placed = Placed(Object(surface=SPHERE))
    assert placed.distance(placed.to_own_frame(mesh.vertices) * 1.001).max() == pytest.approx(1.25e-3, rel=2e-3)


def test_scenes_that_differ_in_material_share_a_mesh(monkeypatch):
    ball = Object(surface=SPHERE)
    scene = Scene(camera=Camera(), objects=(ball,), lights=())
    made = convert.mesh_object(ball, scene, 16)
    glass = Object(surface=SPHERE, material=Material(transparency=1.0), name="glass", shadow=False)
    assert convert.mesh_object(glass, Scene(camera=Camera(fov=30), objects=(glass, ball), lights=()), 16) is made
    others = [Object(surface=SPHERE.model_copy(update={"r": 1.26})), Object(surface=SPHERE, rotation=Rotation(axis=(1, 0, 0), degrees=1)),
              Object(surface=SPHERE.model_copy(update={"center": (0.0, 0.0, 3.0)}))]
    assert all(convert.mesh_object(other, scene, 16) is not made for other in others)
    assert convert.mesh_object(ball, scene, 17) is not made
    with pytest.raises(ValueError):
        made.vertices[0] = 0
    floor = Object(surface=Plane(a=0, b=1, c=0))  # how much of it rays can reach hangs on the scene
    near, far = (Scene(camera=Camera(), objects=(floor,), lights=(), tracing=Tracing(max_distance=d)) for d in (5, 50))
    assert np.ptp(convert.mesh_object(floor, far, 16).vertices) > np.ptp(convert.mesh_object(floor, near, 16).vertices)


def test_no_more_than_some_memory_is_kept(monkeypatch):
    ball, scene = Object(surface=SPHERE), Scene(camera=Camera(), objects=(Object(surface=SPHERE),), lights=())
    first = convert.mesh_object(ball, scene, 20)
    monkeypatch.setattr(convert, "MOST_KEPT", first.nbytes + 1)
    second = convert.mesh_object(ball, scene, 19)
    assert convert.mesh_object(ball, scene, 19) is second and convert.mesh_object(ball, scene, 20) is not first
