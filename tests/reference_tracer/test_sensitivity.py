"""The sensitivity map predicts what rounding does, and excuses nothing else."""

import json
import os
import subprocess
import sys

import numpy as np
import pytest

from raytruth.comparisons.verdicts.metrics import largest_around, uniform_around
from raytruth.reference_tracer import llvm
from raytruth.reference_tracer.scene.library import scene
from raytruth.reference_tracer.scene.load import parse_scene
from raytruth.reference_tracer.tracer.render import UNDECIDED, render
from raytruth.reference_tracer.tracer.sensitivity import (
    FLOOR_UNITS,
    SAFETY,
    UNIT,
    Displaced,
    Perturbations,
    perturbed,
    response,
    sensitivity,
)

MOST_OUTSIDE = 1  # one pixel in ten thousand; the pictures have 12 288
NAMES = ("figure-07-torus", "figure-09-heart", "figure-17-scene1")


@pytest.fixture(scope="module", params=NAMES)
def case(request):
    small = scene(request.param).resized(128, 96)
    return small, sensitivity(small)


def test_renders_in_single_precision_stay_inside(case, tmp_path):
    """With kernels as wide as users have them: they divide less exactly."""
    small, found = case
    (tmp_path / "scene.json").write_text(small.model_dump_json(by_alias=True))
    subprocess.run([sys.executable, "-m", "raytruth", "render", "scene.json", "--precision", "32", "-o", "picture.npz"],
                   env={**os.environ, llvm.NARROW: ""}, cwd=tmp_path, check=True)
    assert np.sum(~found.excuses(np.load(tmp_path / "picture.npz")["color"])) <= MOST_OUTSIDE


def test_renders_perturbed_anew_stay_inside(case):
    small, found = case
    for seed in (101, 102, 103):
        assert np.sum(~found.excuses(perturbed(small, "exact", UNIT[32], seed)[0].color)) <= MOST_OUTSIDE


def test_the_bound_is_not_vacuous(case):
    """Rounding makes a colour jump only where an edge runs through a pixel, so that at rest it or a neighbour has another
    history; and the bound of a pixel looks no farther than its neighbours."""
    small, found = case
    histories = [h.reshape(found.bound.shape) for h in perturbed(small, "exact", 0.0, 0)[1].values()]
    edges = ~np.logical_and.reduce([uniform_around(h) for h in histories])
    near = largest_around(edges) > 0
    assert 0 < near.mean() < 0.7 and not np.any((found.bound >= 1e-4) & ~near)


def test_what_rounding_cannot_do_is_not_excused(case):
    small, found = case
    lit = found.picture.color.max(axis=-1) > 0.05
    assert not found.excuses(found.picture.color * 1.01)[lit & (found.bound < 1e-4)].any()
    other_light = small.model_copy(update={"lights": small.lights[:1]})
    assert np.mean(found.excuses(render(other_light).color)) < 0.9


def test_in_the_corner_of_a_room_the_other_wall_is_what_rounding_may_show():
    """Pixels (2, 1), (2, 78), (57, 1) and (57, 78) look along the lines where the walls of 14 by 10 meet: the picture takes
    the first of the two and leaves them open (decision M4), and a moved ray meets either."""
    found = response(scene("figure-16-refraction-n1.4").resized(80, 60), "exact", 64)
    undecided = found.picture.status == UNDECIDED
    assert undecided[[2, 2, 57, 57], [1, 78, 1, 78]].all() and np.all((found.risk > 0)[undecided])


def test_an_undisturbed_watch_changes_nothing(case):
    small, found = case
    # sums of a pixel's rays are rounded in any order
    assert np.abs(found.picture.color - render(small).color).max() <= 1e-14


def test_the_smooth_response_is_that_of_the_cosine_law():
    # One light straight above a floor seen from above: color = cos(phi) = h / sqrt(h^2 + x^2) of the hit point, whose
    # slope is at most 2 / (3 sqrt(3) h). A ray moved by m units of rounding moves the hit by a few m units times its
    # length; the measured bound must have that size: neither zero nor orders above.
    from raytruth.reference_tracer.scene.model import Scene

    floor = Scene.model_validate_json("""{"camera": {"direction": [0, -1, 0], "up": [0, 0, 1], "width": 24, "height": 24},
        "objects": [{"surface": {"type": "plane", "center": [0, -2, 0], "a": 0, "b": 1, "c": 0}}],
        "lights": [{"position": [0, -1, 0]}]}""")
    found = sensitivity(floor)
    response = (found.bound - FLOOR_UNITS * UNIT[32] * (1 + found.picture.color.max(axis=-1))) / SAFETY
    steepest = 2 / (3 * np.sqrt(3))
    moved = (8 + 4 * 3) * np.sqrt(3) * UNIT[32] * 1.5  # origin and direction, at most 3 long, seen at up to 40 degrees
    assert 0 < np.median(response) <= steepest * moved
    assert (found.risk == 0).all()


@pytest.mark.parametrize("name, method", [("figure-17-scene1", "exact"), ("figure-07-torus", "paper"), ("balls", "exact")])
def test_replayed_pictures_are_those_made_afresh(name, method):
    """One recording serves all perturbations, whose scenes differ in numbers: to the last bit, also where objects make up
    clusters by their places."""
    balls = [{"surface": {"type": "sphere", "center": [k % 5 - 2, k // 5 - 2, 5 + 0.3 * k], "r": 0.4}, "material": {"reflection": 0.3}}
             for k in range(25)]
    turned = {"surface": {"type": "expression", "formula": "x**4 + y**4 + z**4 - 0.3", "center": [0, 0, 3], "bounds": {
        "low": [-1, -1, -1], "high": [1, 1, 1]}}, "rotation": {"axis": [1, 2, 0], "degrees": 40},
        "material": {"transparency": 0.5, "refractive_index": 1.3}}
    base = parse_scene(json.dumps({"name": "balls", "objects": [turned, *balls], "lights": [{"position": [2, 3, -1]}],
                                   "tracing": {"max_depth": 2}}).encode()) if name == "balls" else scene(name)
    small = base.resized(32, 24)
    count = len(small.objects)
    displaced = Displaced((1e-2,) * count, (0.0,) * count, (1e-3,) * count)
    together, pictures = Perturbations(small, method, displaced), {}
    for seed in (0, 1, 2, 7):
        alone = Perturbations(small, method, displaced)
        one, other = (made.picture(UNIT[32] * (seed > 0), seed) for made in (alone, together))
        for plane in ("color", "t", "position", "normal", "index", "depth", "status"):
            assert np.array_equal(getattr(one, plane), getattr(other, plane), equal_nan=True), plane
        assert all((alone.signatures[risk] == together.signatures[risk]).all() for risk in alone.signatures)
        assert (alone.touched == together.touched).all() and (alone.grazing == together.grazing).all()
        pictures[seed] = one.t
    assert len({t.tobytes() for t in pictures.values()}) == 4  # no two are the same
    assert np.array_equal(pictures[0], render(small, method).t)


@pytest.mark.parametrize("samples", [1, 2])
def test_responses_that_share_recordings_are_those_made_alone(samples):
    small = scene("figure-17-scene1").resized(24, 18, samples)
    count, recorded = len(small.objects), {}
    for precision, displaced in ((32, None), (64, Displaced((1e-2,) * count, (1e-2,) * count, (1e-3,) * count)), (64, None)):
        of = {"precision": precision, "displaced": displaced, "probes": 3}
        together, alone = response(small, **of, recorded=recorded), response(small, **of)
        for name in ("color", "t", "normal"):
            assert np.array_equal(together.smooth[name], alone.smooth[name]) and np.array_equal(together.jump[name], alone.jump[name])
        assert all(np.array_equal(getattr(together, plane), getattr(alone, plane)) for plane in ("risk", "seen", "touched", "grazing"))
        assert alone.touched.any() == (displaced is not None)
    assert len(recorded) == samples  # with several samples, the rays through pixels' centres have recordings of their own


@pytest.mark.parametrize("samples", [1, 2])
def test_a_picture_that_nothing_disturbs_is_the_picture(samples):
    """One recording shows world after world: none of them may be left behind in a kernel, also of pixels' centres."""
    tracing = {"samples": samples}
    ball = parse_scene(json.dumps({
        "name": "ball", "camera": {"width": 24, "height": 18}, "lights": [{"position": [2, 2, 0]}], "tracing": tracing,
        "objects": [{"surface": {"type": "sphere", "center": [0, 0, 3], "r": 1}}]}).encode())
    plain, made = render(ball), Perturbations(ball, "exact")
    for unit, seed in ((0.0, 0), (1e-3, 5), (0.0, 0)):
        found = made.picture(unit, seed)
        same = [np.array_equal(getattr(found, plane), getattr(plain, plane), equal_nan=plane != "index")
                for plane in ("color", "t", "normal", "index")]
        assert not same[0] if unit else all(same), same
