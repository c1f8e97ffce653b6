"""Formulas as people write them: read at the first try, and the pictures are those of what they mean."""

import json

import numpy as np
import pytest
from formulas_as_written import FORMULAS, REFUSED, Written

from raytruth.reference_tracer.errors import InputError
from raytruth.reference_tracer.scene.load import parse_scene
from raytruth.reference_tracer.surfaces import Expression
from raytruth.reference_tracer.tracer.camera import canvas_point, frame
from raytruth.reference_tracer.tracer.render import render

WIDTH, HEIGHT = 32, 24
STEPS = 3000  # points of a ray at which the sign of what is meant is looked at
NEAR = 1e-7  # of the distance: how far from a hit both signs must have been seen
MOST_UNDECIDED = 0.1  # of the rays that meet the cube: edges, tangencies, jumps


def scene_of(written: Written):
    corner = [written.size] * 3
    eye = np.array([1.7, 1.3, -2.6]) * written.size
    surface = {"type": "expression", "formula": written.formula, "clip": {"low": [-c for c in corner], "high": corner}}
    if written.parameters:
        surface["parameters"] = written.parameters
    document = {"camera": {"width": WIDTH, "height": HEIGHT, "position": eye.tolist(), "direction": (-eye).tolist(), "fov": 55},
                "objects": [{"surface": surface}], "lights": [{"position": [0, 9, -9]}]}
    return parse_scene(json.dumps(document).encode())


@pytest.mark.parametrize("written", FORMULAS, ids=lambda w: f"{w.origin}: {w.formula[:40]}")
def test_a_formula_as_written_has_the_values_that_are_meant(written):
    surface = Expression(formula=written.formula, parameters=written.parameters)
    points = np.random.default_rng(1).uniform(-written.size, written.size, (3, 400))
    with np.errstate(all="ignore"):
        found, meant = (np.broadcast_to(f(*points), 400) for f in (surface.function, written.means))
    np.testing.assert_allclose(found, meant, rtol=1e-9, atol=1e-9, equal_nan=True)


@pytest.mark.parametrize("origin, text, named", REFUSED)
def test_what_is_refused_is_named_with_its_place(origin, text, named):
    with pytest.raises(InputError) as error:
        scene_of(Written(origin, text, 1, None))
    assert named in str(error.value) and ("column" in str(error.value)) and len(str(error.value).splitlines()) == 1


def test_there_are_as_many_as_were_asked_for():
    assert len(FORMULAS) + len(REFUSED) >= 120 and sum(not w.has_faces for w in FORMULAS) >= 115
    assert len({w.formula for w in FORMULAS}) == len(FORMULAS)


def faults(written: Written, picture, o, d) -> list[str]:
    """How a picture contradicts the signs of what is meant along its rays, `o` and `d` (n, 3), sampled by NumPy alone."""
    def inside(t):
        p = o[:, None] + t[..., None] * d[:, None]
        with np.errstate(all="ignore"):
            f = np.broadcast_to(written.means(*np.moveaxis(p, -1, 0)), p.shape[:-1])
        return (f < 0) & (f > -np.inf) & (np.abs(p) < written.size).all(axis=-1)

    t, hit, decided = picture.t.ravel(), picture.index.ravel() >= 0, picture.status.ravel() != 2
    with np.errstate(all="ignore"):
        slabs = np.sort(np.stack([(s * written.size - o) / d for s in (-1, 1)]), axis=0)
    enters, leaves = slabs[0].max(axis=1), slabs[1].min(axis=1)
    meets = enters < leaves
    found = []
    undecided = np.mean(~decided[meets])
    if undecided > MOST_UNDECIDED and not written.has_faces:
        found.append(f"{undecided:.0%} of the rays that meet the cube are undecided")
    end = np.where(hit & decided, t * (1 - NEAR), leaves)
    share = (np.arange(STEPS) + 0.5) / STEPS
    early = inside(enters[:, None] + (end - enters)[:, None] * share) & (end > enters)[:, None]
    wrong = early.any(axis=1) & decided & meets
    if wrong.any():
        found.append(f"{wrong.sum()} rays pass through the solid")
    at = np.stack([t * (1 - NEAR), t * (1 + NEAR)], axis=1)
    seen = inside(np.where(np.isfinite(at), at, 0))
    wrong = hit & decided & ~(~seen[:, 0] & seen[:, 1])
    if wrong.any():
        found.append(f"{wrong.sum()} hits are where nothing begins")
    return found


def rays(scene):
    camera = frame(scene.camera)
    row, col = (plane.ravel().astype(float) for plane in np.mgrid[:HEIGHT, :WIDTH])
    x, y = canvas_point(camera, row, col, 0, 0, 1)
    d = x[:, None] * camera.v_x + y[:, None] * camera.v_y + camera.v_dir
    return np.broadcast_to(camera.v_pos, d.shape), d / np.linalg.norm(d, axis=1, keepdims=True)


@pytest.mark.slow
@pytest.mark.parametrize("written", FORMULAS, ids=lambda w: f"{w.origin}: {w.formula[:40]}")
def test_the_picture_of_a_formula_as_written_is_that_of_what_is_meant(written):
    scene = scene_of(written)
    picture = render(scene, "exact")
    assert np.count_nonzero((picture.index >= 0) | (picture.status == 2)) > 5
    assert faults(written, picture, *rays(scene)) == []


def test_another_meaning_is_found():
    """The same check refutes pictures of another formula: a sphere a hundredth larger, one more hole, a sign."""
    sphere = Written("", "x² + y² + z² = 1", 1.2, lambda x, y, z: x**2 + y**2 + z**2 - 1)
    scene = scene_of(sphere)
    picture, (o, d) = render(scene, "exact"), rays(scene)
    assert faults(sphere, picture, o, d) == []
    for means in (lambda x, y, z: x**2 + y**2 + z**2 - 1.02, lambda x, y, z: x**2 + y**2 + z**2 - 0.98,
                  lambda x, y, z: np.maximum(x**2 + y**2 + z**2 - 1, 0.05 - x**2 - y**2),
                  lambda x, y, z: 1 - x**2 - y**2 - z**2):
        assert faults(Written("", "", 1.2, means), picture, o, d) != []
