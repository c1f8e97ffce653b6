"""Solids joined: the signs of a union, an intersection, a difference along every ray, from the parts' own signs."""

import json

import numpy as np
import pytest
from tracing_support import shoot

from raytruth.reference_tracer.errors import InputError
from raytruth.reference_tracer.scene.load import parse_scene
from raytruth.reference_tracer.tracer.render import render

BALL = {"type": "sphere", "r": 1}
CUBE = {"type": "expression", "formula": "max(|x|, |y|, |z|) = R", "parameters": {"R": 0.8}, "bounds": {"low": [-0.8] * 3, "high": [0.8] * 3}}
RING = {"type": "torus", "R": 0.9, "r": 0.3, "center": [0.2, 0, 0.1]}
FLOOR = {"type": "plane", "a": 0, "b": 1, "c": 0, "center": [0, -0.3, 0]}
INSIDE = {  # of points about the whole's centre, by hand
    "ball": lambda x, y, z: x * x + y * y + z * z < 1, "cube": lambda x, y, z: np.maximum(np.maximum(abs(x), abs(y)), abs(z)) < 0.8,
    "ring": lambda x, y, z: (np.hypot(x - 0.2, y) - 0.9)**2 + (z - 0.1)**2 < 0.09, "floor": lambda x, y, z: y < -0.3}
PARTS = {"ball": BALL, "cube": CUBE, "ring": RING, "floor": FLOOR}
JOINED = {
    "union": lambda first, *others: np.logical_or.reduce([first, *others]),
    "intersection": lambda first, *others: np.logical_and.reduce([first, *others]),
    "difference": lambda first, *others: first & ~np.logical_or.reduce(others)}
CASES = [("union", ("ball", "ring")), ("union", ("cube", "ball", "ring")), ("intersection", ("ball", "cube")),
         ("intersection", ("ring", "floor")), ("difference", ("cube", "ball")), ("difference", ("ball", "ring", "floor")),
         ("union", ("ball", "floor"))]


def scene_with(surface, **camera):
    document = {"camera": {"width": 40, "height": 30, **camera}, "objects": [{"surface": {**surface, "center": [0.1, 0.2, 4]}}],
                "lights": [{"position": [3, 5, -2]}]}
    return parse_scene(json.dumps(document).encode())


@pytest.mark.parametrize("operation, names", CASES, ids=lambda v: v if isinstance(v, str) else "-".join(v))
def test_rays_change_side_where_the_joined_solids_do(operation, names):
    scene = scene_with({"type": "csg", "operation": operation, "of": [PARTS[n] for n in names]})
    random = np.random.default_rng(5)
    center = np.array([0.1, 0.2, 4.0])
    o = center + random.normal(size=(400, 3)) * 1.5
    d = center + random.uniform(-0.8, 0.8, (400, 3)) - o
    d /= np.linalg.norm(d, axis=1)[:, None]

    def inside(t):
        p = np.moveaxis(o[:, None] + t[..., None] * d[:, None] - center, -1, 0)
        return JOINED[operation](*(INSIDE[n](*p) for n in names))

    start = inside(np.zeros((400, 1)))[:, 0]
    found = [shoot(scene, o[start == side], d[start == side], inside=[bool(side)]) for side in (False, True)]
    t, index, undecided = (np.empty(400, kind) for kind in (float, int, bool))
    for side, hits in zip((False, True), found):
        t[start == side], index[start == side], undecided[start == side] = hits.t, hits.index, hits.undecided
    assert undecided.mean() < 0.02 and (index == 0).sum() > 100
    hit = ~undecided & (index == 0)
    end = np.where(hit, t - 1e-9, 8.0)
    along = inside(end[:, None] * (np.arange(2000) + 0.5) / 2000)
    assert (along == start[:, None])[~undecided].all()
    assert (inside((t + 1e-9)[:, None])[:, 0] != start)[hit].all()


def test_bounds_follow_from_those_of_the_parts():
    box = lambda operation, *of: scene_with({"type": "csg", "operation": operation, "of": list(of)}).objects[0].surface.box()
    np.testing.assert_allclose(box("union", BALL, RING), ((-1, -1.2, -1), (1.4, 1.2, 1)), rtol=1e-12)
    np.testing.assert_allclose(box("intersection", RING, FLOOR, BALL), ((-1, -1, -0.2), (1, 1, 0.4)), rtol=1e-12)
    np.testing.assert_allclose(box("difference", CUBE, FLOOR), ((-0.8,) * 3, (0.8,) * 3), rtol=1e-12)
    assert box("union", BALL, FLOOR) is None and box("difference", FLOOR, BALL) is None
    assert box("intersection", {**BALL, "inside": "positive"}, CUBE) == ((-0.8,) * 3, (0.8,) * 3)


def test_it_is_the_formula_that_says_the_same():
    """A drilled cube as csg, nested and clipped, and as one formula: the same picture."""
    drill = {"type": "expression", "formula": "x^2 + y^2 < 0.25"}
    half = {"type": "csg", "operation": "difference", "of": [CUBE, drill], "clip": {"low": [-1, -0.5, -1], "high": [1, 0.5, 1]}}
    whole = {"type": "csg", "operation": "union", "of": [half, {**BALL, "r": 0.3}]}
    text = "(max(|x|,|y|,|z|) < 0.8 and not x^2 + y^2 < 0.25 and |y| < 0.5) or x^2 + y^2 + z^2 < 0.09"
    a, b = render(scene_with(whole), "exact"), render(scene_with({"type": "expression", "formula": text}), "exact")
    np.testing.assert_array_equal(a.index, b.index)
    decided = (a.status != 2) & (b.status != 2)
    np.testing.assert_allclose(a.t[decided], b.t[decided], rtol=1e-13)
    np.testing.assert_allclose(a.color[decided], b.color[decided], atol=1e-12)
    assert (a.index >= 0).sum() > 150 and decided.mean() > 0.97


def test_a_scene_with_one_survives_its_file_and_numbers_are_no_structure():
    scenes = [scene_with({"type": "csg", "operation": "difference", "of": [{**CUBE, "clip": {"low": [-1] * 3, "high": [1, 1, s]}},
                                                                         {**BALL, "r": r}]}) for s, r in ((1, 1), (0.5, 0.9))]
    a, b = (scene.objects[0].surface for scene in scenes)
    assert a.family == b.family and scenes[0].hash != scenes[1].hash
    again = parse_scene(scenes[0].model_dump_json(by_alias=True).encode())
    assert again == scenes[0] and again.hash == scenes[0].hash


@pytest.mark.parametrize("broken, told", [
    ({"of": [BALL]}, "objects[0].surface.of"), ({"operation": "sum", "of": [BALL, CUBE]}, "objects[0].surface.operation"),
    ({"of": [BALL, {**CUBE, "formula": "x +"}]}, "objects[0].surface.of[1].formula"), ({"of": [BALL, {"type": "box"}]}, "objects[0].surface.of[1]")])
def test_faults_are_told_with_their_place(broken, told):
    with pytest.raises(InputError) as error:
        scene_with({"type": "csg", "operation": "union", **broken})
    assert told in str(error.value) and len(str(error.value).splitlines()) == 1
