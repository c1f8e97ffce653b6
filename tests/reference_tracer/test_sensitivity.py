"""The sensitivity map predicts what rounding does, and excuses nothing else."""

import numpy as np
import pytest

from reference_tracer.scene.library import scene
from reference_tracer.tracer.render import render
from reference_tracer.tracer.sensitivity import FLOOR_UNITS, SAFETY, UNIT, perturbed, sensitivity

MOST_OUTSIDE = 1  # one pixel in ten thousand; the pictures have 12 288
NAMES = ("figure-07-torus", "figure-09-heart", "figure-17-scene1")


@pytest.fixture(scope="module", params=NAMES)
def case(request):
    small = scene(request.param).resized(128, 96)
    return small, sensitivity(small)


def test_renders_in_single_precision_stay_inside(case):
    small, found = case
    assert np.sum(~found.excuses(render(small, precision=32).color)) <= MOST_OUTSIDE


def test_renders_perturbed_anew_stay_inside(case):
    small, found = case
    for seed in (101, 102, 103):
        assert np.sum(~found.excuses(perturbed(small, "exact", UNIT[32], seed)[0].color)) <= MOST_OUTSIDE


def test_the_bound_is_not_vacuous(case):
    _, found = case
    # rims and shadow edges take a larger share of a small picture: of figure 17, which has most of them, 0.075 here,
    # 0.066 at 256 x 192, 0.053 at 640 x 480
    assert np.mean(found.bound < 1e-4) >= 0.92


def test_what_rounding_cannot_do_is_not_excused(case):
    small, found = case
    lit = found.picture.color.max(axis=-1) > 0.05
    assert not found.excuses(found.picture.color * 1.01)[lit & (found.bound < 1e-4)].any()
    other_light = small.model_copy(update={"lights": small.lights[:1]})
    assert np.mean(found.excuses(render(other_light).color)) < 0.9


def test_an_undisturbed_watch_changes_nothing(case):
    small, found = case
    # sums of a pixel's rays are rounded in any order
    assert np.abs(found.picture.color - render(small).color).max() <= 1e-14


def test_the_smooth_response_is_that_of_the_cosine_law():
    # One light straight above a floor seen from above: color = cos(phi) = h / sqrt(h^2 + x^2) of the hit point, whose
    # slope is at most 2 / (3 sqrt(3) h). A ray moved by m units of rounding moves the hit by a few m units times its
    # length; the measured bound must have that size: neither zero nor orders above.
    from reference_tracer.scene.model import Scene

    floor = Scene.model_validate_json("""{"camera": {"direction": [0, -1, 0], "up": [0, 0, 1], "width": 24, "height": 24},
        "objects": [{"surface": {"type": "plane", "center": [0, -2, 0], "a": 0, "b": 1, "c": 0}}],
        "lights": [{"position": [0, -1, 0]}]}""")
    found = sensitivity(floor)
    response = (found.bound - FLOOR_UNITS * UNIT[32] * (1 + found.picture.color.max(axis=-1))) / SAFETY
    steepest = 2 / (3 * np.sqrt(3))
    moved = (8 + 4 * 3) * np.sqrt(3) * UNIT[32] * 1.5  # origin and direction, at most 3 long, seen at up to 40 degrees
    assert 0 < np.median(response) <= steepest * moved
    assert (found.risk == 0).all()
