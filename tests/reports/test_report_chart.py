"""Studies as charts: coordinates against the definition of logarithmic axes."""

import math

import pytest

from comparisons.results import Series
from reports.axis import MOST_TICKS, log_ticks
from reports.chart import chart


def series(**lines) -> Series:
    return Series(id="a study", title="t", x_label="x", y_label="y", lines=lines, expected="e", holds=True, command="c")


def test_a_power_law_is_a_straight_line():
    points = chart(series(law=[(x, 3 * x**-2.0) for x in (32.0, 64.0, 100.0, 256.0)])).lines[0].points
    slopes = [(b.y - a.y) / (b.x - a.x) for a, b in zip(points, points[1:])]
    assert max(slopes) - min(slopes) < 1e-2 * abs(slopes[0])
    assert points[0].y < points[-1].y  # coordinates run downwards: an error that falls goes down


def test_equal_ratios_are_equal_distances_on_both_axes():
    points = chart(series(law=[(1.0, 1.0), (10.0, 100.0), (100.0, 1e4)])).lines[0].points
    assert points[1].x - points[0].x == pytest.approx(points[2].x - points[1].x, abs=0.02)
    assert points[1].y - points[0].y == pytest.approx(points[2].y - points[1].y, abs=0.02)


def test_zeros_lie_in_a_band_below_the_axis_and_break_the_line():
    drawn = chart(series(law=[(0.001, 0.0), (0.01, 3.0), (0.1, 40.0), (1.0, 0.0)]))
    assert drawn.has_zeros
    zeros = [p for p in drawn.lines[0].points if p.values[1] == 0]
    assert len(zeros) == 2 and all(p.y > drawn.floor for p in zeros)
    assert all(p.y <= drawn.floor for p in drawn.lines[0].points if p.values[1] > 0)
    assert [len(s.split()) for s in drawn.lines[0].segments] == [2]


def test_points_without_a_place_are_counted_not_hidden():
    drawn = chart(series(law=[(-1.0, 1.0), (1.0, -1.0), (1.0, math.nan), (math.inf, 1.0), (1.0, 1.0)]))
    assert drawn.left_out == 4 and len(drawn.lines[0].points) == 1


@pytest.mark.parametrize("lines", [{}, {"none": []}, {"zero": [(1.0, 0.0)]}, {"one": [(5.0, 5.0)]}])
def test_charts_of_almost_nothing_can_be_drawn(lines):
    chart(series(**lines))


@pytest.mark.parametrize("low, high", [(1e-16, 1e3), (0.9, 1.2), (32, 256), (1e-5, 3e-2), (0.5, 11.0)])
def test_ticks_are_round_inside_and_few(low, high):
    ticks = log_ticks(low, high)
    assert 0 < len(ticks) <= MOST_TICKS and all(low <= t <= high for t in ticks)
    assert all(f"{t:.15e}"[0] in "1235" and float(f"{t:.0e}") == t for t in ticks)


def test_few_distinct_x_values_are_the_ticks():
    drawn = chart(series(law=[(x, 1 / x) for x in (32.0, 64.0, 128.0, 256.0)]))
    assert [tick.label.text for tick in drawn.x_ticks] == ["32", "64", "128", "256"]
