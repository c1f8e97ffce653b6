"""Surfaces as Mitsuba's grids against the exact reference."""

import itertools

import numpy as np
import pytest

from raytruth.comparisons.renderers.mitsuba import render as render_mitsuba
from raytruth.converters.mitsuba import convert, document_directions, grid
from raytruth.reference_tracer.errors import InputError
from raytruth.reference_tracer.scene.model import Material, Object, Rotation
from raytruth.reference_tracer.scene.placement import rotation_matrix
from raytruth.reference_tracer.surfaces import Ellipsoid, Expression, Heart, Paraboloid, Plane, Sphere, Torus
from raytruth.reference_tracer.tracer.render import render

TURNED = Rotation(axis=(1.0, 0.2, 0.4), degrees=50.0)


def compared(scene, resolution):
    """Depth's and normal's error at the pixels that a ray meets at no grazing angle, and the number that miss."""
    exact, seen = render(scene, "exact"), render_mitsuba(scene, shapes="sdfgrid", resolution=resolution, repeat=False)
    d = document_directions(scene.camera).reshape(*exact.t.shape, 3)
    facing = np.isfinite(exact.t) & np.isfinite(seen.t) & (np.abs((exact.normal * d).sum(-1)) > 0.3)
    missed = int((np.isfinite(exact.t) != np.isfinite(seen.t)).sum())
    depth, normal = np.abs(seen.t[facing] - exact.t[facing]), (seen.normal - exact.normal)[facing]
    return depth, np.linalg.norm(normal, axis=-1), missed


@pytest.mark.parametrize("surface", [
    Torus(center=(0.2, -0.1, 3.5), R=0.8, r=0.3), Heart(center=(0.0, 0.0, 3.0)),
    Ellipsoid(center=(0.1, 0.2, 3.0), a=1.1, b=0.5, c=0.25), Sphere(center=(0.0, 0.0, 3.0), r=1.0),
    Expression(center=(0.0, 0.0, 3.0), formula="x**4 + y**4 + z**4 - 1",
               bounds={"low": (-1.0, -1.0, -1.0), "high": (1.0, 1.0, 1.0)})], ids=lambda s: s.type)
def test_turned_surfaces_of_all_proportions(scene_of, surface):
    """Resolution 96, boxes of different sides: h is at most 0.03; h^2 / 8 an axis at a radius of 0.25 is 1.4e-3."""
    scene = scene_of(Object(surface=surface, rotation=TURNED), width=160, height=120)
    depth, normal, missed = compared(scene, 96)
    assert depth.size > 800 and missed <= 12
    assert np.quantile(depth, 0.95) < 1.4e-3 and np.quantile(normal, 0.95) < 2e-2


@pytest.mark.parametrize("surface", [Torus(center=(0.0, 0.0, 3.0), R=0.8, r=0.3),
                                     Sphere(center=(0.0, 0.0, 3.0), r=1.0)], ids=lambda s: s.type)
def test_errors_fall_with_the_square_of_the_resolution(scene_of, surface):
    scene = scene_of(surface, width=192, height=144)
    errors = [[np.quantile(e, 0.9) for e in compared(scene, n)[:2]] for n in (24, 48, 96)]
    for coarse, fine in itertools.pairwise(errors):
        assert all(3.2 < a / b < 4.9 for a, b in zip(coarse, fine))


def test_the_measured_error_bounds_what_rays_see(scene_of):
    scene = scene_of(Sphere(center=(0.0, 0.0, 3.0), r=1.0), width=160, height=120)
    depth, _, _ = compared(scene, 48)
    error = convert(scene, "sdfgrid", 48).parts[0].error
    assert 0.3 * error < depth.max() < error / 0.3  # along the ray, at up to acos(0.3)


@pytest.mark.parametrize("rotation", [None, TURNED])
def test_the_stated_error_of_normals_is_what_rays_see(scene_of, rotation):
    """Where they meet the grid, wherever that is."""
    surface = Ellipsoid(center=(0.1, 0.2, 3.0), a=1.1, b=0.5, c=0.4)
    scene = scene_of(Object(surface=surface, rotation=rotation), width=160, height=120)
    seen, turn = render_mitsuba(scene, shapes="sdfgrid", resolution=48, repeat=False), rotation_matrix(rotation)
    met = seen.index == 0
    exact = (seen.position[met] - surface.center) @ turn / np.square([1.1, 0.5, 0.4]) @ turn.T
    angle = np.linalg.norm(exact / np.linalg.norm(exact, axis=1, keepdims=True) - seen.normal[met], axis=1)
    stated = convert(scene, "sdfgrid", 48).parts[0].normal_error
    assert 0.5 * stated < np.quantile(angle, 0.99) < 1.5 * stated


def test_what_has_no_bounds_keeps_its_exact_shape_or_its_mesh(scene_of):
    scene = scene_of(Plane(center=(0.0, -1.0, 0.0), a=0.0, b=1.0, c=0.0),
                     Paraboloid(center=(0.0, 0.0, 3.0), a=0.7, b=0.9), Sphere(center=(0.0, 0.0, 3.0), r=0.5))
    parts = convert(scene, "sdfgrid", 24).parts
    assert [p.kind for p in parts] == ["native", "mesh", "sdfgrid"]
    assert all("cut" in p.clipped for p in parts[:2]) and not parts[2].clipped


def test_mirrors_and_glass_on_grids(scene_of):
    """Secondary rays start on a grid: shading follows the exact reference within the grid's error."""
    floor = Plane(center=(0.0, -1.0, 0.0), a=0.0, b=1.0, c=0.0)
    glass = Material(color=(0.9, 0.8, 0.7), transparency=0.8, refractive_index=1.3)
    scene = scene_of(floor, Object(surface=Sphere(center=(-0.8, 0.0, 4.0), r=0.9), material=Material(reflection=0.7)),
                     Object(surface=Sphere(center=(0.9, -0.2, 3.0), r=0.7), material=glass))
    exact, seen = render(scene, "exact"), render_mitsuba(scene, shapes="sdfgrid", resolution=64, repeat=False)
    error = np.abs(seen.color - exact.color).max(-1)
    assert (seen.status == 2).sum() == 0 and np.median(error) < 2e-5 and np.quantile(error, 0.95) < 1e-2


def test_swapped_axes_are_found(scene_of, monkeypatch):
    """The wrong implementation: Mitsuba's grids are stored z, y, x."""
    scene = scene_of(Torus(center=(0.0, 0.0, 3.0), R=0.8, r=0.3), width=160, height=120)
    monkeypatch.setattr(grid, "_sampled", lambda *a, sampled=grid._sampled: sampled(*a).transpose(2, 1, 0))
    monkeypatch.setattr(grid, "_errors", lambda *_: (0.0, 0.0))
    assert compared(scene, 48)[2] > 100


@pytest.mark.parametrize("resolution", [4, 1000])
def test_impossible_resolutions_are_one_sentence(scene_of, resolution):
    with pytest.raises(InputError, match="a grid needs a resolution of 8 to 384 cells"):
        convert(scene_of(Sphere(center=(0.0, 0.0, 3.0), r=1.0)), "sdfgrid", resolution)
