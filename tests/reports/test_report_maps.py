"""Errors between planes, derived by hand, and the pictures of one side."""

import numpy as np
import pytest

from reference_tracer.tracer.render import HIT, MISS, UNDECIDED
from reports import maps, scale
from reports.planes import Planes
from reports.rings import around_marks, around_worst
from reports.spread import spread


def planes(color=0.5, t=2.0, normal=(0.0, 0.0, -1.0), index=0, status=HIT) -> Planes:
    """One pixel."""
    return Planes(np.full((1, 1, 3), color), np.full((1, 1), t), np.array([[normal]], float),
                  np.full((1, 1), index, np.int32), np.full((1, 1), status, np.uint8))


EMPTY = planes(t=np.inf, normal=(np.nan,) * 3, index=-1, status=MISS)


def test_colour_error_is_the_largest_channels():
    test = planes()
    test.color[0, 0] = 0.5 + 1e-3, 0.5 - 2e-2, 0.5
    assert maps.errors(planes(), test).color[0, 0] == pytest.approx(2e-2, rel=1e-12)


def test_depth_error_is_relative_to_the_reference():
    # |2.5 - 2| / 2, not / 2.5
    assert maps.errors(planes(t=2.0), planes(t=2.5)).depth[0, 0] == 0.25


@pytest.mark.parametrize("angle", [1e-12, 1e-8, 1e-3, 1.0, 3.0])
def test_normal_error_is_the_angle_even_where_a_dot_product_has_lost_it(angle):
    # (sin a, 0, -cos a) is the normal turned by a; acos of the dot product would be 0 for a < 1e-8
    turned = planes(normal=(np.sin(angle), 0.0, -np.cos(angle)))
    assert maps.errors(planes(), turned).normal[0, 0] == pytest.approx(angle, rel=1e-9)


def test_two_misses_have_no_geometry_to_differ():
    errors = maps.errors(EMPTY, EMPTY)
    assert errors.depth[0, 0] == errors.normal[0, 0] == 0
    assert errors.nothing[0, 0] and not errors.mismatch[0, 0]


@pytest.mark.parametrize("test", [EMPTY, planes(index=1)])
def test_another_object_or_none_is_a_mismatch(test):
    errors = maps.errors(planes(), test)
    assert errors.mismatch[0, 0] and not errors.nothing[0, 0]


@pytest.mark.parametrize("faulty, plane", [(planes(color=np.nan), "color"), (planes(color=np.inf), "color"),
                                           (planes(t=np.inf), "depth"), (planes(normal=(np.nan,) * 3), "normal")])
@pytest.mark.parametrize("swap", [False, True])
def test_what_is_not_finite_is_seen_from_both_sides(faulty, plane, swap):
    pair = (faulty, planes()) if swap else (planes(), faulty)
    errors = maps.errors(*pair).named()
    assert {name for name, error in errors.items() if np.isnan(error[0, 0])} == {plane}


def test_infinite_colours_on_both_sides_are_not_equal():
    # inf - inf is NaN, not 0
    assert np.isnan(maps.errors(planes(color=np.inf), planes(color=np.inf)).color[0, 0])


def test_depth_is_lighter_the_nearer_on_a_logarithmic_range():
    near, middle, far = (maps.depth_picture(planes(t=t), (1.0, 4.0))[0, 0].astype(int) for t in (1.0, 2.0, 4.0))
    assert (near > middle).all() and (middle > far).all()
    # t = 2 is half way from 1 to 4, and 256 greys lie evenly in lightness
    expected = maps.from_oklch((maps.NEAR + maps.FAR) / 2, 0.0, 0.0).astype(int)
    assert np.abs(middle - expected).max() <= 1
    assert (maps.depth_picture(EMPTY, (1.0, 4.0))[0, 0] == maps.NOTHING).all()


def test_normals_map_minus_one_to_one_onto_the_channels():
    # (n + 1) / 2 * 255, rounded: -1 -> 0, 0 -> 128, 1 -> 255
    assert maps.normal_picture(planes(normal=(0.0, 1.0, -1.0)))[0, 0].tolist() == [128, 255, 0]


def test_objects_have_colours_of_their_own():
    assert len({tuple(c) for c in maps.object_colours(24)}) == 24
    assert (maps.object_picture(planes(index=3), 2)[0, 0] == maps.object_colours(4)[3]).all()
    assert (maps.object_picture(planes(status=UNDECIDED), 1)[0, 0] == scale.UNDECIDED).all()


def test_spread_counts_every_pixel_once():
    error = np.array([[0.0, 0.0, 1e-3, np.nan, 0.5, 0.5]])
    row = lambda *flags: np.array([flags], bool)
    errors = maps.Errors(error, error, error, error, nothing=row(1, 0, 0, 0, 0, 0), mismatch=row(0, 0, 0, 1, 1, 1),
                         undecided=row(0, 0, 0, 0, 0, 1))
    found = spread(error, errors)
    assert (found.nothing, found.equal, found.largest) == (1, 1, 1e-3)
    assert [(swatch.name, count) for swatch, count in found.marked] == [
        ("another object", 1), ("undecided", 1), ("not finite", 1)]
    assert len(found.bars) == 1 and found.bars[0].x == pytest.approx(100 * 6 / 9)  # 1e-3 is six of nine decades up


def test_rings_lie_around_pixel_centres_inside_the_picture():
    worst = [{"row": 2, "col": 5, "error": 1.0}, {"row": 3, "col": 0, "error": 1.0}, {"error": 1.0}]
    assert [(ring.x, ring.y) for ring in around_worst(worst, (3, 6))] == [(5.5, 2.5)]
    many = np.ones((20, 20), bool)
    few = np.zeros((20, 20), bool)
    few[4, 7] = True
    error = np.zeros((20, 20))
    rings = around_marks(maps.Errors(error, error, error, error, nothing=~many, mismatch=few, undecided=~many))
    assert [(ring.x, ring.y) for ring in rings] == [(7.5, 4.5)]
    assert around_marks(maps.Errors(error, error, error, error, nothing=~many, mismatch=many, undecided=~many)) == ()
