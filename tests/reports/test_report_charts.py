"""Charts: where their marks stand, what is named, and that nothing of a file of its own stays in the page."""

import itertools
import re

import pytest
from report_support import HOSTILE, marks_of

from raytruth.comparisons.results import Series
from raytruth.reports.build import STATIC, environment, static
from raytruth.reports.figures.charts import HEIGHT, MARKS, MOST_TICKS, PAGE, WIDTH, Axis, Line, chart, log_ticks
from raytruth.reports.pages.front import study


def drawn(*lines: Line, nothing=0.0, few=False, **more) -> str:
    points = [point for line in lines for point in line.points]
    return chart("a", "t", Axis("x", [x for x, _ in points], few=few),
                 Axis("y", [y for _, y in points], nothing), lines, **more)


def test_a_power_law_is_a_straight_line_that_falls():
    points = marks_of(drawn(Line("law", [(x, 3 * x**-2.0) for x in (32.0, 64.0, 100.0, 256.0)])), "a-0")
    slopes = [(d - b) / (c - a) for (a, b), (c, d) in itertools.pairwise(points)]
    assert max(slopes) - min(slopes) < 1e-2 * abs(slopes[0])
    assert points[0][1] < points[-1][1]  # coordinates run downwards: an error that falls goes down


def test_equal_ratios_are_equal_distances_on_both_axes():
    (a, b), (c, d), (e, f) = marks_of(drawn(Line("law", [(1.0, 1.0), (10.0, 100.0), (100.0, 1e4)])), "a-0")
    assert c - a == pytest.approx(e - c, abs=0.05) and d - b == pytest.approx(f - d, abs=0.05)


def test_errors_that_are_none_stand_in_a_band_below_the_axis_and_others_above_it():
    line = Line("law", [(1.0, 1e-3), (2.0, 1e-12), (3.0, 0.0), (4.0, 2e-12)])
    y = [point[1] for point in marks_of(drawn(line, nothing=1e-12), "a-0")]
    assert y[1] == y[2] > y[3] > y[0]
    axis = Axis("", [1e-3, 1e-12, 2e-12], nothing=1e-12)
    assert axis.floor < axis.place(1e-12) < axis.range[0] < axis.place(2e-12)
    assert not Axis("", [1.0, 2.0]).has_band


def test_series_in_the_band_do_not_hide_each_other():
    svg = drawn(*(Line(f"m{k}", [(1.0, 0.0), (2.0, 5.0)], k) for k in range(5)))
    y = sorted(marks_of(svg, f"a-{k}")[0][1] for k in range(5))
    assert min(b - a for a, b in itertools.pairwise(y)) >= 8


def test_every_series_is_named_inside_the_drawing_and_apart_from_the_others():
    names = [f"series {k}" for k in range(8)]
    svg = drawn(*(Line(name, [(1.0, 2.0 + k / 50), (3.0, 4.0 + k / 50)], k) for k, name in enumerate(names)))
    places = [tuple(map(float, re.search(rf'x="([\d.]+)" y="([\d.]+)"[^>]*>{name}</text>', svg).groups())) for name in names]
    assert all(0 < x < WIDTH and 0 < y < HEIGHT for x, y in places)
    assert all(abs(a[1] - b[1]) > 10 or abs(a[0] - b[0]) > 50 for k, a in enumerate(places) for b in places[:k])


def test_nothing_but_the_drawing_stays_and_its_texts_are_texts():
    lines = Line(HOSTILE, [(1.0, 1.0), (2.0, 2.0)]), Line("$x$ --> 3.14159", [(1.0, 2.0)])
    svg = drawn(*lines, frontier=[(1.0, 1.0)])
    assert not re.search(r"https?:|<script|<style|<metadata|<!|#00fe|font-family|url", svg)
    ids, used = re.findall(r' id="([^"]*)"', svg), set(re.findall(r'href="#(\w+)"', svg))
    assert len(ids) == len(set(ids)) and set(ids) == used | {"a-0", "a-1"}
    assert "$x$ --&gt; 3.14159<" in svg and "<svg class=\"chart\"" in svg
    assert svg == drawn(*lines, frontier=[(1.0, 1.0)])


def test_every_colour_of_a_chart_is_one_of_the_page_in_both_themes():
    style = static(environment())[STATIC[0]]
    assert all(len(re.findall(rf"--{name}: #", style)) >= 2 for name in PAGE)
    assert len(set(MARKS)) == len(MARKS)


def test_points_without_a_place_are_left_to_the_table():
    points = [(-1.0, 1.0), (1.0, -1.0), (1.0, float("nan")), (float("inf"), 1.0), (1.0, 1.0), (2.0, 0.0)]
    svg = study(Series(id="s", title="t", x_label="x", y_label="y", lines={"law": points}, expected="e", holds=True,
                       command="c", slope={"law": -2.0}))
    assert len(marks_of(svg, "study-s-0")) == 2 and "law, slope −2" in svg


@pytest.mark.parametrize("points", [None, [], [(1.0, 0.0)], [(5.0, 5.0)]])
def test_charts_of_almost_nothing_can_be_drawn(points):
    assert "</svg>" in drawn(*([] if points is None else [Line("one", points)]))


@pytest.mark.parametrize("low, high", [(1e-16, 1e3), (0.9, 1.2), (32, 256), (1e-5, 3e-2), (0.5, 11.0)])
def test_ticks_are_round_inside_and_few(low, high):
    ticks = log_ticks(low, high)
    assert 0 < len(ticks) <= MOST_TICKS and all(low <= t <= high for t in ticks)
    assert all(f"{t:.15e}"[0] in "1235" and float(f"{t:.0e}") == t for t in ticks)


def test_few_distinct_x_values_are_the_ticks():
    assert list(Axis("x", [32.0, 64.0, 128.0, 256.0], few=True).ticks.values()) == ["32", "64", "128", "256"]


def test_a_linear_axis_runs_from_nothing_to_all():
    axis = Axis("share", [0.3, 1.0], step=0.25)
    assert axis.range == (0.0, 1.0) and list(axis.ticks) == [0.0, 0.25, 0.5, 0.75, 1.0]
