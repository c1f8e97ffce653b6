"""Errors between planes, derived by hand."""

import numpy as np
import pytest

from raytruth.reference_tracer.tracer.render import HIT, MISS
from raytruth.reports.figures import maps
from raytruth.reports.figures.maps import around_worst, spread
from raytruth.reports.figures.planes import Planes


def planes(color=0.5, t=2.0, normal=(0.0, 0.0, -1.0), index=0, status=HIT) -> Planes:
    """One pixel."""
    return Planes(np.full((1, 1, 3), color), np.full((1, 1), t), np.array([[normal]], float),
                  np.full((1, 1), index, np.int32), np.full((1, 1), status, np.uint8))


EMPTY = planes(t=np.inf, normal=(np.nan,) * 3, index=-1, status=MISS)


def test_colour_error_is_the_largest_channels():
    test = planes()
    test.color[0, 0] = 0.5 + 1e-3, 0.5 - 2e-2, 0.5
    assert maps.errors(planes(), test).color[0, 0] == pytest.approx(2e-2, rel=1e-12)


def test_two_misses_have_nothing_to_differ():
    errors = maps.errors(EMPTY, EMPTY)
    assert errors.nothing[0, 0] and not errors.mismatch[0, 0]


@pytest.mark.parametrize("test", [EMPTY, planes(index=1)])
def test_another_object_or_none_is_a_mismatch(test):
    errors = maps.errors(planes(), test)
    assert errors.mismatch[0, 0] and not errors.nothing[0, 0]


@pytest.mark.parametrize("value", [np.nan, np.inf])
@pytest.mark.parametrize("swap", [False, True])
def test_what_is_not_finite_is_seen_in_either_picture(value, swap):
    pair = (planes(color=value), planes()) if swap else (planes(), planes(color=value))
    assert np.isnan(maps.errors(*pair).color[0, 0])


def test_infinite_colours_on_both_sides_are_not_equal():
    # inf - inf is NaN, not 0
    assert np.isnan(maps.errors(planes(color=np.inf), planes(color=np.inf)).color[0, 0])


def test_objects_have_colours_of_their_own():
    assert len({tuple(c) for c in maps.object_colours(24)}) == 24


def test_spread_counts_every_pixel_once():
    error = np.array([[0.0, 0.0, 1e-3, np.nan, 0.5, 0.5]])
    row = lambda *flags: np.array([flags], bool)
    errors = maps.Errors(error, nothing=row(1, 0, 0, 0, 0, 0), mismatch=row(0, 0, 0, 1, 1, 1),
                         undecided=row(0, 0, 0, 0, 0, 1))
    found = spread(error, errors)
    assert (found.nothing, found.equal) == (1, 1)
    assert (found.largest, found.largest_shown) == (0.5, 1e-3)  # another object's error counts as well
    assert [(swatch.name, count) for swatch, count in found.special] == [
        ("another object", 1), ("undecided", 1), ("not finite", 1)]
    assert len(found.bars) == 1 and found.bars[0].x == pytest.approx(100 * 6 / 9)  # 1e-3 is six of nine decades up


def test_rings_lie_around_pixel_centres_inside_the_picture():
    worst = [{"row": 2, "col": 5, "error": 1.0}, {"row": 3, "col": 0, "error": 1.0}, {"error": 1.0}]
    assert [(ring.x, ring.y) for ring in around_worst(worst, (3, 6))] == [(5.5, 2.5)]
