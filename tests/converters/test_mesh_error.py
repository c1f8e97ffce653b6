"""The geometric error of a mesh: measured rightly, falling with the square of the resolution, met and not undercut."""

import numpy as np
import pytest

from converters.mesh import check, mesh_object, mesh_to_error
from converters.mesh.convert import interior_errors
from converters.mesh.placed import Placed
from reference_tracer.errors import InputError
from reference_tracer.scene.model import Object
from reference_tracer.surfaces import Ellipsoid, Expression, Heart, Paraboloid, Plane, Sphere, Torus
from reference_tracer.surfaces.expression import Bounds

TORUS = Torus(R=0.8, r=0.3)


def test_error_is_the_distance_of_the_facets_from_a_sphere(mesh_of):
    """Points spread over the triangles lie 1 - |p| below the unit sphere: the measured maximum is theirs, nearly."""
    mesh = mesh_of(Sphere(r=1.0))
    weights = np.random.default_rng(1).dirichlet((1, 1, 1), 40)
    deepest = max((1 - np.linalg.norm(np.einsum("k,mkj->mj", w, mesh.vertices[mesh.faces]), axis=1)).max()
                  for w in weights)
    assert 0.99 * deepest < mesh.error < 1.2 * deepest
    assert mesh.error_p99 <= mesh.error


def test_first_order_distance_of_a_flat_triangle():
    """Corners on the unit circle z = 0: the middles of the sides have |p| = cos(60 degrees) = 1/2."""
    angle = np.radians([0, 120, 240])
    corners = np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)
    *sides, centre = sorted(interior_errors(Placed(Object(surface=Sphere(r=1.0))), corners, np.array([[0, 1, 2]])))
    # |f| / |grad f| of f = |p|^2 - 1 is (1 - 1/4) / (2 * 1/2) there; in the centre the gradient vanishes
    assert sides == pytest.approx([0.75, 0.75, 0.75]) and centre > 1e6


@pytest.mark.parametrize("surface", [TORUS, Sphere(r=1.0), Ellipsoid(a=1.0, b=0.6, c=0.4), Paraboloid(a=1.0, b=0.7)],
                         ids=lambda s: s.type)
def test_error_falls_with_the_square_of_the_resolution(mesh_of, surface):
    errors = [mesh_of(surface, n).error_p99 for n in (32, 64, 128)]
    assert 3.6 < errors[0] / errors[1] < 4.4
    assert 3.6 < errors[1] / errors[2] < 4.4


def test_vertices_that_were_not_projected_break_the_law(scene_of, monkeypatch):
    """The wrong implementation: marching cubes' own vertices, linear along grid edges, lie off the surface."""
    monkeypatch.setattr("converters.mesh.convert.project", lambda placed, vertices, cell: vertices)
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
