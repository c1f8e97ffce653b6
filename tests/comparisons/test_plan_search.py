"""What is decided, on scenes whose needs follow from theory."""

import math

import numpy as np
import pytest
from planning_support import BALL, FLOOR, HEIGHT, REFLECTION, WIDTH, corridor, scene, searching

from raytruth.comparisons.planning.decisions import (
    cheapest,
    cutoff,
    effects,
    first_hit,
    max_distance,
    objects,
    precision,
    recursion_depth,
    removable,
    samples,
    shadows,
)
from raytruth.comparisons.planning.search import MOST_EXCUSED, OutOfTime, RayStatistics, Yardstick, deciding

EVERY = np.ones((HEIGHT, WIDTH), bool)
NEEDED = 3  # generations: without those beyond a pixel changes by R^4 = 1e-4; one less and it is R^3 = 1e-3, too much


@pytest.mark.parametrize("length", [1, 2, 7, 8, 50])
def test_the_ladder_finds_the_first_rung_that_holds(length):
    for boundary in range(length + 1):
        asked = []
        found = cheapest(range(length), lambda rung: asked.append(rung) or rung >= boundary)
        assert found == (boundary if boundary < length else None)
        assert len(asked) <= math.log2(length) + 1 + 1e-9


def test_a_rung_that_was_not_asked_is_never_chosen():
    holding = {3, 9, 10, 17}  # not monotone
    assert cheapest(range(20), holding.__contains__) in holding


def test_halves_are_random_fixed_and_disjoint():
    first = deciding("ab" * 32, 101, 33)
    assert first.sum() == (101 * 33 + 1) // 2 and (first == deciding("ab" * 32, 101, 33)).all()
    assert 0.4 < (first == deciding("ab" * 32, 101, 33, attempt=2)).mean() < 0.6
    assert 0.4 < (first == deciding("cd" * 32, 101, 33)).mean() < 0.6
    assert 0.4 < first[::2].mean() < 0.6  # not by rows


def test_depth_is_what_a_geometric_series_needs():
    decision, = recursion_depth(searching(corridor()))
    assert decision.planned == str(NEEDED)
    measured = {t.value: t.change for t in decision.trials}
    series = {str(d): REFLECTION ** (d + 1) - REFLECTION**9 for d in range(9)}
    assert measured.keys() >= {"2", "3"} and measured == {d: pytest.approx(series[d], rel=0.02) for d in measured}


def test_a_cutoff_leaves_out_the_generations_that_do_not_show():
    search = searching(corridor())
    decision, = cutoff(search)
    assert RayStatistics(decision.change(search.scene), EVERY).generations == NEEDED


def test_a_shadow_matters_where_one_falls_and_not_on_a_ball_alone():
    together, alone = (next(effects(searching(scene(*parts)))) for parts in ((FLOOR, BALL), (BALL,)))
    assert together.change is None and together.trials[0].change > 0.1
    assert alone.planned == "left out" and alone.trials[0].change == 0


def test_reflection_matters_between_mirrors_and_refraction_is_none():
    decisions = {d.parameter: d for d in effects(searching(corridor()))}
    assert decisions["reflection"].change is None
    assert decisions["reflection"].trials[0].change == pytest.approx(REFLECTION, rel=0.02)
    assert decisions["refraction"].planned == "left out" and not decisions["refraction"].trials


def test_an_object_is_dropped_only_if_neither_it_nor_its_shadow_shows():
    behind = {"name": "behind", "surface": {"type": "sphere", "center": [0, 0, -6], "r": 1}}
    above = {"name": "above", "surface": {"type": "sphere", "center": [0, 20, 4], "r": 1}}
    search = searching(scene(FLOOR, behind, above, lights=[(0, 40, 4)]))
    decision, = objects(search)
    assert [o.name for o in decision.change(search.scene).objects] == ["floor", "above"]
    assert "behind" in decision.evidence and "above" not in decision.evidence


def test_only_shadows_that_fall_on_something_are_kept():
    search = searching(scene(FLOOR, BALL))
    decision, = shadows(search)
    assert [o.shadow for o in decision.change(search.scene).objects] == [False, True]  # nothing lies below the floor
    assert decision.planned == "1" and "floor" in decision.evidence


def test_groups_that_share_their_fate_are_asked_once():
    asked = []
    needed = {3, 11, 12}
    found = removable([range(10), range(10, 20)], lambda things: asked.append(things) or not needed & set(things), 100)
    assert sorted(found) == [k for k in range(20) if k not in needed] and len(asked) < 20
    assert removable([range(8)], lambda things: False, 3) == []


def test_one_object_stays_though_none_shows():
    behind = {"surface": {"type": "sphere", "center": [0, 0, -6], "r": 1}}
    search = searching(scene(behind, behind))
    decision, = objects(search)
    assert len(decision.change(search.scene).objects) == 1


def test_samples_are_taken_where_edges_are():
    search = searching(scene(BALL, samples=4), tolerance=0.01)
    decision, = samples(search)
    tracing = decision.change(search.scene).tracing
    assert tracing.samples == 4 and tracing.adaptive > 0
    assert decision.trials[0].value == "1 x 1" and decision.trials[0].change > 0.1  # half a pixel of the ball's edge
    assert samples(searching(scene(BALL)))[0].change is None


def test_single_precision_is_refused_where_its_rounding_shows():
    decision, = precision(searching(scene(BALL), tolerance=1e-9))
    assert decision.change is None and 1e-9 < decision.trials[0].change < 1e-5


def test_rays_end_behind_the_farthest_hit():
    search = searching(scene(BALL))
    decision, = max_distance(search)
    assert 3.5 < decision.change(search.scene).tracing.max_distance < 4.5  # the ball's outline is sqrt(15) = 3.87 away


def test_a_closed_form_is_left_alone_and_a_step_too_large_is_refused():
    ring = {"surface": {"type": "torus", "center": [0, 0, 4], "R": 1, "r": 0.1},
            "rotation": {"axis": [1, 0, 0], "degrees": 60}}
    sphere, torus = (next(first_hit(searching(scene(solid)))) for solid in (BALL, ring))
    assert sphere.change is None and not sphere.trials
    steps = {float(t.value.split()[-1]): t.holds for t in torus.trials if t.value.startswith("paper")}
    assert all(not holds for h, holds in steps.items() if h > 0.2)  # longer than the ring is thick
    assert "exact" in torus.evidence


def test_a_search_out_of_time_says_so():
    search = searching(scene(BALL))
    search.deadline = 0
    with pytest.raises(OutOfTime):
        search.holds("anything", lambda s: s)


def test_only_what_rounding_may_change_is_excused():
    written = scene(BALL)
    yardstick = Yardstick(written.resized(64, 48), tolerance=1e-3)
    pixels = np.ones((48, 64), bool)
    allowed = int(MOST_EXCUSED * pixels.size)
    bound = np.full(pixels.shape, 1e-6)
    bound[10] = 0.5
    yardstick._bounds[32] = bound
    change = np.zeros(pixels.shape)
    change[10, :allowed] = 0.4
    found = yardstick.difference(change, pixels, 32)
    assert allowed > 0 and (found.largest, found.excused, found.excused_largest, found.over) == (0, allowed, 0.4, 0)
    change[20, 3] = 0.002  # rounding does not move this pixel
    assert yardstick.difference(change, pixels, 32).largest >= 0.002
    change[20, 3], change[10, 0] = 0, 0.6  # more than rounding moves it
    assert yardstick.difference(change, pixels, 32).largest == 0.6
    change[20, 3], change[10, 0] = 9.5e-4, 0.4  # within the tolerance, but not within a smaller limit
    assert yardstick.difference(change, pixels, 32).over == 0
    change[10, 0] = 0  # leaves room for one
    assert yardstick.difference(change, pixels, 32, limit=9e-4).over == 1
    bound[20, 3] = 1e-3
    assert yardstick.difference(change, pixels, 32, limit=9e-4).over == 0
    change[20, 3], change[10, 0], change[10, allowed] = 0, 0.4, 0.4  # one too many
    assert yardstick.difference(change, pixels, 32).largest == 0.4
    assert np.isinf(yardstick.from_truth(yardstick.color * np.nan)).all()
