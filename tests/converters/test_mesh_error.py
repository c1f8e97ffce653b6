"""The geometric error of a mesh: measured rightly, falling with the square of the resolution, met and not undercut."""

import numpy as np
import pytest

from raytruth.converters.mesh import check, mesh_object, mesh_to_error
from raytruth.converters.mesh.error import bounds, of_normals, of_triangles
from raytruth.converters.mesh.placed import Placed
from raytruth.reference_tracer.errors import InputError
from raytruth.reference_tracer.scene.model import Object
from raytruth.reference_tracer.surfaces import Ellipsoid, Expression, Heart, Paraboloid, Plane, Sphere, Torus
from raytruth.reference_tracer.surfaces.expression import Bounds

TORUS = Torus(R=0.8, r=0.3)


def test_error_is_the_distance_of_the_facets_from_a_sphere(mesh_of):
    """Points spread over the triangles lie 1 - |p| below the unit sphere: the measured maximum is theirs, nearly."""
    mesh = mesh_of(Sphere(r=1.0))
    assert deepest(mesh) <= mesh.error < 1.2 * deepest(mesh)
    assert mesh.error_p99 <= mesh.error


def placed(surface) -> Placed:
    return Placed(Object(surface=surface))


def test_bounds_of_a_flat_triangle():
    """Corners on the unit circle z = 0: the middles of the sides have |p| = 1/2; in the centre grad f vanishes."""
    angle = np.radians([0, 120, 240])
    corners = np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)
    *sides, centre, between = of_triangles(placed(Sphere(r=1.0)), corners, np.array([[0, 1, 2]]))
    assert all(0.5 <= side < 0.76 for side in sides)  # first order says (1 - 1/4) / (2 * 1/2) = 0.75
    assert 1 <= centre < 1.2 and between == pytest.approx(4 / 3 * sides[0])  # of a parabola in the middle


def test_normals_of_a_flat_triangle():
    """Over the parabola z = x^2 / 2 from x = 0 to 1 the interpolated normal turns back by half of atan 1, grad f by
    atan 1/2; along the third edge nothing turns."""
    corners = np.array([[0, 0, 0], [1, 0, 0.5], [0, 1, 0]])
    normals = np.array([[0, 0, 1], [-(0.5**0.5), 0, 0.5**0.5], [0, 0, 1]])
    one, two, three, centre = of_normals(placed(Expression(formula="z - x**2/2")), corners, normals, np.array([[0, 1, 2]]))
    assert two == pytest.approx(0, abs=1e-15) and one == pytest.approx(np.arctan(0.5) - np.pi / 8) == pytest.approx(three)
    # two normals straight up and one at 45 degrees; x = 1/3 below the centroid
    assert centre == pytest.approx(np.arctan(1 / 3) - np.arctan(0.5**0.5 / (2 + 0.5**0.5)))


def test_the_error_of_normals_is_what_points_of_triangles_show(mesh_of):
    """Anywhere on the triangles, 99 % of the area keep it, not by far; it falls with the square of the resolution."""
    coarse, fine = mesh_of(TORUS, 32), mesh_of(TORUS, 64)
    assert 3 < coarse.normal_error / fine.normal_error < 5
    a, b, c = fine.vertices[fine.faces.T]
    random = np.random.default_rng(1)
    chosen = random.choice(len(a), 4000, p=(area := np.linalg.norm(np.cross(b - a, c - a), axis=1)) / area.sum())
    weights = random.dirichlet((1, 1, 1), 4000)
    at = lambda corners: np.einsum("nk,nkj->nj", weights, corners[fine.faces[chosen]])
    p, n = at(fine.vertices), at(fine.normals)
    ring = np.array([[1, 1, 0]]) * p  # the nearest point of the circle within the torus is straight ahead of its normal
    exact = p - TORUS.R * ring / np.linalg.norm(ring, axis=1, keepdims=True)
    cos = np.einsum("ij,ij->i", n, exact) / np.linalg.norm(n, axis=1) / np.linalg.norm(exact, axis=1)
    assert 0.5 * fine.normal_error < np.quantile(np.arccos(np.minimum(cos, 1)), 0.99) <= 1.05 * fine.normal_error
    assert mesh_of(Sphere(r=1.0), 32).normal_error < 1e-14  # there interpolation is exact


FAMILIES = {  # f, and the exact distance of points of space from its zeros
    "polynomial": ("x**2 + y**2 + z**2 - 1", lambda p: abs(np.linalg.norm(p, axis=1) - 1)),
    "steep": ("(x**2 + y**2 + z**2)**8 - 1", lambda p: abs(np.linalg.norm(p, axis=1) - 1)),
    "triple root, no gradient": ("(x**2 + y**2 + z**2 - 1)**3", lambda p: abs(np.linalg.norm(p, axis=1) - 1)),
    "kinks": ("max(max(abs(x), abs(y)), abs(z)) - 1", lambda p: np.where(
        (abs(p) < 1).all(axis=1), 1 - abs(p).max(axis=1), np.linalg.norm(np.maximum(abs(p) - 1, 0), axis=1))),
    "gradient of NaN": ("x**2 + y**2 + z**2 - 1 + 0*sqrt(abs(x - y))*0", lambda p: abs(np.linalg.norm(p, axis=1) - 1))}


@pytest.mark.parametrize("name", FAMILIES)
@pytest.mark.parametrize("size", [0.3, 1e-2, 1e-5, 1e-12])
def test_no_bound_is_below_the_distance(name, size):
    formula, distance = FAMILIES[name]
    random = np.random.default_rng(4)
    points = random.normal(size=(400, 3))
    points /= (np.abs(points).max(axis=1) if name == "kinks" else np.linalg.norm(points, axis=1))[:, None]
    points *= 1 + size * random.uniform(-1, 1, (400, 1))
    points[:40, 1] = points[:40, 0]  # where the gradient is NaN
    facets = random.normal(size=(400, 3))
    facets /= np.linalg.norm(facets, axis=1, keepdims=True)
    found = bounds(placed(Expression(formula=formula)), points, facets)
    exact = distance(points)
    assert (found >= exact - 1e-15).all()
    assert np.median(found / np.maximum(exact, 1e-15)) < 1.3


def test_where_f_is_not_defined_no_bound_is_claimed():
    """A pole changes the sign too and is no surface; beyond a domain's edge there is nothing to find."""
    facing = np.array([[1.0, 0.0, 0.0]])
    assert np.isinf(bounds(placed(Expression(formula="1/x")), 1e-3 * facing, facing)).all()
    assert np.isinf(bounds(placed(Expression(formula="sqrt(x) + 1")), 1e-3 * facing, facing)).all()
    assert np.isinf(bounds(placed(Expression(formula="x**2 + y**2 + 1e-3")), 1e-3 * facing, facing)).all()  # no surface
    assert bounds(placed(Expression(formula="x")), 1e-3 * facing, facing) == pytest.approx(1e-3, rel=2e-3)


NAN = "x**2 + y**2 + z**2 - 1 + 0*cbrt(0*x)"  # the ball; its gradient is NaN everywhere
CUBE = Bounds(low=(-1.0,) * 3, high=(1.0,) * 3)


def deepest(mesh):
    """How far the triangles go into the unit ball, on 40 points of each."""
    weights = np.random.default_rng(1).dirichlet((1, 1, 1), 40)
    return max((1 - np.linalg.norm(np.einsum("k,mkj->mj", w, mesh.vertices[mesh.faces]), axis=1)).max() for w in weights)


def test_gradients_of_nan_hide_no_error(mesh_of):
    """Vertices cannot be projected then: the error is large, about a quarter of a cell squared, and is told."""
    mesh = mesh_of(Expression(formula=NAN, bounds=CUBE), 32)
    assert mesh.error >= deepest(mesh) > 1e-3 and mesh.residual is None and mesh.normal_error is None
    assert mesh_of(Sphere(r=1.0), 32).residual < 1e-15


def test_what_cannot_be_measured_is_no_number(mesh_of, scene_of):
    """f jumps where x = 0.5, across a pole: the mesh has a sheet there that is no surface."""
    jump = Expression(formula="max(1/(x - 0.5), x**2 + y**2 + z**2 - 1)", clip=CUBE)
    mesh = mesh_of(jump, 32)
    assert mesh.error is None and mesh.triangles
    with pytest.raises(InputError, match="cannot be measured.*share"):
        mesh_to_error(scene_of(jump).objects[0], scene_of(jump), 1e-2)


def test_the_most_curved_triangles_are_looked_at(scene_of, monkeypatch):
    """The heart's error lies at its tips, few triangles of many: a hundredth of all finds the same one."""
    scene = scene_of(Heart())
    everywhere = mesh_object(scene.objects[0], scene, 64)
    monkeypatch.setattr("raytruth.converters.mesh.convert.MEASURED", everywhere.triangles // 25)
    assert mesh_object(scene.objects[0], scene, 64).error == everywhere.error


@pytest.mark.parametrize("sharp", [Sphere(r=1.0, clip=Bounds(low=(-2.0, -2.0, 0.1), high=(2.0, 2.0, 2.0))),
                                   Sphere(r=1.3, clip=CUBE, inside="positive"), Plane(a=0.3, b=1.0, c=0.2, clip=CUBE)])
def test_the_error_of_a_clipped_solid_holds_its_edges(mesh_of, sharp):
    """Marching cubes cut edges off by a part of a cell: that is the error, and it falls with the cell only."""
    coarse, fine = mesh_of(sharp, 32), mesh_of(sharp, 64)
    assert check(fine).watertight and fine.closed and not check(fine).faults(fine)
    assert 1.2 < coarse.error / fine.error < 3.5 and fine.error > 1e-3
    assert fine.error_p99 <= fine.error


def test_volumes_of_clipped_solids(mesh_of):
    """A spherical cap of height 0.9: pi h^2 (3 - h) / 3; half a cube; each within area times error."""
    cap = mesh_of(Sphere(r=1.0, clip=Bounds(low=(-2.0, -2.0, 0.1), high=(2.0, 2.0, 2.0))), 64)
    half = mesh_of(Plane(a=0.3, b=1.0, c=0.2, clip=CUBE), 64)
    for mesh, volume in ((cap, np.pi * 0.81 * 2.1 / 3), (half, 4.0)):
        found = check(mesh)
        assert found.euler_number == 2 and abs(found.volume - volume) <= found.area * mesh.error


@pytest.mark.parametrize("surface", [TORUS, Sphere(r=1.0), Ellipsoid(a=1.0, b=0.6, c=0.4), Paraboloid(a=1.0, b=0.7)],
                         ids=lambda s: s.type)
def test_error_falls_with_the_square_of_the_resolution(mesh_of, surface):
    errors = [mesh_of(surface, n).error_p99 for n in (32, 64, 128)]
    assert 3.6 < errors[0] / errors[1] < 4.4
    assert 3.6 < errors[1] / errors[2] < 4.4


def test_vertices_that_were_not_projected_break_the_law(scene_of, monkeypatch):
    """The wrong implementation: marching cubes' own vertices, linear along grid edges, lie off the surface."""
    monkeypatch.setattr("raytruth.converters.mesh.convert.project", lambda placed, vertices, cell: vertices)
    scene = scene_of(TORUS)
    mesh = mesh_object(scene.objects[0], scene, 64)
    assert mesh.residual > 1e-4


@pytest.mark.parametrize("surface", [TORUS, Sphere(r=1.0), Paraboloid(a=1.0, b=1.0)], ids=lambda s: s.type)
@pytest.mark.parametrize("error", [1e-2, 1e-3])
def test_meets_a_stated_error_and_is_no_finer(scene_of, surface, error):
    scene = scene_of(surface)
    mesh = mesh_to_error(scene.objects[0], scene, error)
    assert mesh.error <= error
    coarser = mesh_object(scene.objects[0], scene, int(0.8 * mesh.resolution))
    assert coarser.error > error


def test_a_plane_is_exact_at_any_resolution(scene_of):
    scene = scene_of(Plane(a=0.3, b=1.0, c=-0.2, center=(0.0, -1.0, 2.0)))
    assert mesh_to_error(scene.objects[0], scene, 1e-9).error < 1e-12


def test_edges_need_a_share(scene_of):
    """The tips of the heart cannot be met to 1e-4, but 99 % of it can: the caller says so, nothing is hidden."""
    scene = scene_of(Heart())
    with pytest.raises(InputError, match="too fine"):
        mesh_to_error(scene.objects[0], scene, 1e-4)
    mesh = mesh_to_error(scene.objects[0], scene, 1e-4, share=0.99)
    assert mesh.error_p99 <= 1e-4 < mesh.error and check(mesh).euler_number == 2


@pytest.mark.parametrize("resolution", [3, 5000, -1])
def test_impossible_resolutions(scene_of, resolution):
    scene = scene_of(TORUS)
    with pytest.raises(InputError, match="at least 4|at most 4096"):
        mesh_object(scene.objects[0], scene, resolution)


def test_a_surface_that_falls_between_grid_points_is_not_lost_silently(scene_of):
    """A ball of radius 1/100 in bounds of side 2: no point of a grid of 16 cells lies inside."""
    bounds = Bounds(low=(-1.0, -1.0, -1.0), high=(1.0, 1.0, 1.0))
    scene = scene_of(Expression(formula="x**2 + y**2 + z**2 - 0.0001", bounds=bounds))
    with pytest.raises(InputError, match="larger resolution"):
        mesh_object(scene.objects[0], scene, 16)
    assert check(mesh_object(scene.objects[0], scene, 512)).euler_number == 2


def test_refuses_more_triangles_than_fit(scene_of):
    scene = scene_of(Expression(formula="sin(5*x)*cos(5*y) + sin(5*y)*cos(5*z) + sin(5*z)*cos(5*x)"))
    with pytest.raises(InputError, match="would have about .* triangles"):
        mesh_object(scene.objects[0], scene, 1024)


@pytest.mark.parametrize("error, share, message", [
    (0.0, 1.0, "positive number"), (float("nan"), 1.0, "positive number"), (-1.0, 1.0, "positive number"),
    (1e-3, 0.0, "share"), (1e-3, 1.5, "share")])
def test_impossible_errors(scene_of, error, share, message):
    scene = scene_of(TORUS)
    with pytest.raises(InputError, match=message):
        mesh_to_error(scene.objects[0], scene, error, share)
