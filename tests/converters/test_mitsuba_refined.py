"""Hits on meshes moved onto f: what is left is shading in single precision."""

import numpy as np
import pytest

from raytruth.comparisons.renderers.mitsuba import render as render_mitsuba
from raytruth.converters.mitsuba import refine
from raytruth.reference_tracer.scene.model import Material, Object, Rotation
from raytruth.reference_tracer.surfaces import Ellipsoid, Heart, Paraboloid, Plane, Torus
from raytruth.reference_tracer.tracer.render import render

SURFACES = [Torus(center=(0.2, -0.1, 3.5), R=0.8, r=0.3), Heart(center=(0.0, 0.0, 3.0)),
            Ellipsoid(center=(0.1, 0.2, 3.0), a=1.1, b=0.5, c=0.25), Paraboloid(center=(0.0, -0.5, 3.0), a=0.7, b=0.9)]


def errors(scene, **options):
    """Of depth, normals and colour at pixels that both sides hit at no grazing angle."""
    exact = render(scene, "exact")
    seen = render_mitsuba(scene, **{"shapes": "native", "resolution": 96, "refined": True, "repeat": False, **options})
    ray = exact.position - np.array(scene.camera.position)
    both = np.isfinite(exact.t) & np.isfinite(seen.t) & (seen.index == exact.index)
    both &= np.abs((ray * exact.normal).sum(-1)) > 0.3 * np.linalg.norm(ray, axis=-1)
    return (np.abs(seen.t[both] / exact.t[both] - 1), np.linalg.norm((seen.normal - exact.normal)[both], axis=-1),
            np.abs(seen.color - exact.color).max(-1)[both])


@pytest.mark.parametrize("surface", SURFACES, ids=lambda s: s.type)
def test_a_coarse_mesh_is_enough(scene_of, surface):
    """96 cells err by 1e-4 to 1e-3; refined, position and normal are those of fp32, at every such pixel."""
    turned = Object(surface=surface, rotation=Rotation(axis=(1.0, 0.2, 0.4), degrees=50.0))
    scene = scene_of(turned, width=160, height=120)
    depth, normal, color = errors(scene)
    assert depth.size > 800 and depth.max() < 1e-6
    assert np.quantile(normal, 0.999) < 1e-5 and np.quantile(color, 0.99) < 2e-6
    assert errors(scene, refined=False)[0].max() > 1e-4


def test_mirrors_glass_and_shadows_of_refined_meshes(scene_of):
    floor = Object(surface=Plane(center=(0.0, -1.0, 0.0), a=0.0, b=1.0, c=0.0), material=Material(reflection=0.3))
    ring = Object(surface=Torus(center=(-0.7, 0.0, 4.0), R=0.7, r=0.3), material=Material(reflection=0.6))
    glass = Object(surface=Ellipsoid(center=(0.9, -0.2, 3.0), a=0.7, b=0.6, c=0.5),
                   material=Material(transparency=0.8, refractive_index=1.3))
    scene = scene_of(floor, ring, glass, width=160, height=120)
    assert np.quantile(errors(scene, resolution=256)[2], 0.98) < 5e-6
    assert np.quantile(errors(scene, resolution=256, refined=False)[2], 0.98) > 5e-5


def test_too_few_steps_are_found(scene_of, monkeypatch):
    monkeypatch.setattr(refine, "STEPS", 0)
    assert errors(scene_of(SURFACES[0], width=160, height=120))[0].max() > 1e-4
