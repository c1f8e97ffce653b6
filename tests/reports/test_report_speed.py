"""Speed against accuracy: where points stand, what the frontier is, and the pages."""

import re

import pytest
from report_support import HOSTILE, make_results

import reports
from comparisons import document
from comparisons.bench.document import Spread
from comparisons.charting.document import (FILE, Accuracy, Chart, Growth, GrowthLine, GrowthPoint, Point, Series,
                                          Subject, Times, Uncertainty)
from reference_tracer.scene import library
from reports.chart import MARKS
from reports.scatter import BAND, BOTTOM, HEIGHT, WIDTH, Row, Style, Value, scatter
from reports.speed import Speed
from reports.templating import STATIC, environment, static


def spread(seconds: float) -> Spread:
    return Spread(median=seconds, low=0.5 * seconds, high=2 * seconds)


def point(seconds=None, wrong=0, label="", depth=1e-9, state="ok", message="", others=0.0) -> Point:
    if state != "ok":
        return Point(label=label, value=None, settings={}, state=state, message=message)
    times = Times(wall=spread(seconds), cpu=spread(2 * seconds))
    return Point(label=label, value=None, settings={}, state="ok", picture=times, hits=times, turns=3,
                 evaluations=10 * seconds, peak_mib=100, compiling=0.5, others=others,
                 accuracy=Accuracy(pixels=1000, wrong=wrong, visible=wrong, depth_p99=depth, depth_max=depth,
                                   color_p99=depth, color_max=depth, undecided=0))


def series(id, *points, kind="first hits", method="") -> Series:
    return Series(id=id, method=method or id, title=f"{id}", kind=kind, parameter="h", points=list(points))


def make_chart(*rows: Series, title="Ball", finding="all is well") -> Chart:
    subject = Subject(id="figure-05-sphere", title=title, kind="surface", width=40, height=25, objects=1, pixels=1000,
                      undecided=0, series=list(rows), findings=[finding], command=f"raytruth chart {HOSTILE}",
                      uncertainty=Uncertainty(depth_p99=1e-13, depth_max=1e-12, color_p99=1e-13, color_max=1e-12))
    grown = [GrowthPoint(x=x, state="ok", picture=Times(wall=spread(1 / x), cpu=spread(1.0)), rays=7, peak_mib=9,
                         second=1 / x) for x in (1.0, 2.0, 4.0)]
    growth = lambda id: Growth(id=id, title=id, x_label=id, second_label="share", finding=f"{id} grow", others=0.0,
                               lines=[GrowthLine(label="exact", points=grown)], command="raytruth chart --growth")
    machine = make_results(library.scene("figure-05-sphere")).machine
    return Chart(created="2025", seconds=9, machine=machine, threads=2, turns=3, truth="a proof",
                 subjects=[subject], growths=[growth("threads"), growth("pixels")])


STEPS = series("paper", point(0.1, 300, "h 0.1"), point(0.2, 30, "h 0.05"), point(0.8, 0, "h 0.01"))
EXACT = series("exact", point(0.3, 0, depth=1e-14))
CRASHED = series("other", point(state="crashed", message=f"signal 11 {HOSTILE}"), kind="converter")
CRUDE = series("crude", point(0.05, 900), kind="control")
ALL = (STEPS, EXACT, CRASHED, CRUDE)


def value(cost, error) -> Value:
    return Value(cost, error, f"{cost}", cost, cost)


def test_equal_ratios_are_equal_distances_and_down_is_more_accurate():
    drawn = scatter("a", "t", "x", "y", [Row(Style("m", 0), (value(1, 1000), value(10, 100), value(100, 10)))])
    a, b, c = drawn.rows[0].points
    assert b.x - a.x == pytest.approx(c.x - b.x, abs=0.02) and b.x > a.x
    assert b.y - a.y == pytest.approx(c.y - b.y, abs=0.02) and b.y > a.y
    assert not drawn.has_zeros and not drawn.has_gutter


def test_errors_up_to_the_uncertainty_stand_in_the_band_and_others_above_it():
    values = value(1, 1e-3), value(2, 1e-12), value(3, 0), value(4, 2e-12)
    drawn = scatter("a", "t", "x", "y", [Row(Style("m", 0), values)], nothing=1e-12)
    y = [p.y for p in drawn.rows[0].points]
    base = HEIGHT - BOTTOM
    assert drawn.has_zeros and drawn.floor == base - BAND
    assert all(drawn.floor < y[k] < base for k in (1, 2)) and all(y[k] <= drawn.floor for k in (0, 3))


def test_marks_of_several_methods_in_the_band_do_not_hide_each_other():
    drawn = scatter("a", "t", "x", "y", [Row(Style(f"m{k}", k), (value(1, 0),)) for k in range(5)])
    y = sorted(row.points[0].y for row in drawn.rows)
    assert min(b - a for a, b in zip(y, y[1:])) >= 10


def test_the_frontier_leaves_out_controls_and_what_is_beaten():
    chart = Speed(make_chart(*ALL)).subjects[0].main
    best = {(row.style.label, k) for row in chart.rows for k, p in enumerate(row.points) if p.best}
    # 0.8 s for no wrong pixel is beaten by exact's 0.3 s; the crude control is cheapest and does not count
    assert best == {("paper", 0), ("paper", 1), ("exact", 0)}
    corners = [tuple(map(float, corner.split(","))) for corner in chart.frontier.split()]
    assert all(b[0] >= a[0] and b[1] >= a[1] for a, b in zip(corners, corners[1:]))  # never up, never back


def test_a_failure_stands_in_the_gutter_with_its_reason():
    chart = Speed(make_chart(*ALL)).subjects[0].main
    other = next(row for row in chart.rows if row.style.label == "other")
    assert chart.has_gutter and not other.points and "signal 11" in other.failed[0].text
    assert WIDTH - chart.right < other.failed[0].x < WIDTH
    assert all(p.x <= WIDTH - chart.right for row in chart.rows for p in row.points)


def test_the_clock_of_a_busy_machine_is_the_processors():
    quiet, busy = Speed(make_chart(EXACT)), Speed(make_chart(series("exact", point(0.3, others=1.5))))
    assert (quiet.clock, busy.clock) == ("wall", "cpu")
    assert "300 ms" in quiet.subjects[0].main.rows[0].points[0].text
    assert "600 ms" in busy.subjects[0].main.rows[0].points[0].text
    threads = busy.growths[0][1][0]
    assert threads.y_label.startswith("wall")  # threads can only be told apart by it


def test_series_of_a_method_share_a_colour_and_differ_in_their_filling():
    speed = Speed(make_chart(STEPS, series("paper-32", point(1.0), method="paper"), EXACT, CRUDE))
    styles = speed.styles
    assert styles["paper"].number == styles["paper-32"].number != styles["exact"].number
    assert [styles[id].hollow for id in ("paper", "paper-32", "exact")] == [False, True, False]
    assert styles["crude"].muted and styles["crude"].mark not in MARKS


def test_every_mark_has_a_colour_in_both_themes():
    style = static(environment())[STATIC[0]]
    for k in range(len(MARKS)):
        assert f".line-{k} {{ color: var(--line-{k}); }}" in style
        assert len(re.findall(rf"--line-{k}: #", style)) == 2
    assert len(set(MARKS)) == len(MARKS)


def test_efficiency_has_a_linear_axis_from_nothing_to_all():
    time, efficiency = Speed(make_chart(EXACT)).growths[0][1]
    y = [p.y for p in efficiency.rows[0].points]
    assert y[2] - y[1] == pytest.approx((y[1] - y[0]) / 2, abs=0.02)  # 1, 1/2, 1/4
    falls = [p.y for p in time.rows[0].points]
    assert falls[2] - falls[1] == pytest.approx(falls[1] - falls[0], abs=0.02)  # in the logarithm


def test_the_pages_are_there_only_with_their_document(folder, tmp_path):
    html = reports.build(folder, tmp_path / "html").parent
    assert not (html / "speed.html").exists() and not (html / "speed").exists()
    document.write(make_chart(*ALL, title=f"Ball {HOSTILE}", finding=f"found {HOSTILE}"), folder / FILE)
    reports.build(folder, html)
    overview = (html / "speed.html").read_text(encoding="utf-8")
    subject = (html / "speed" / "figure-05-sphere.html").read_text(encoding="utf-8")
    for page in (overview, subject):
        assert HOSTILE not in page and page.count("<script") == 1
        assert "<svg class=\"chart scatter\"" in page
    assert "1 point without a result" in overview and "signal 11" in overview
    assert 'href="speed/figure-05-sphere.html"' in overview and 'href="../speed.html"' in subject
    for told in ("crashed: signal 11", "h 0.05", "two cores"):
        assert told in subject or told in overview
    assert subject.count("<svg class=\"chart scatter\"") == 8
    assert 'href="speed.html"' in (html / "index.html").read_text(encoding="utf-8")


def test_a_subject_without_a_truth_says_why(folder, tmp_path):
    chart = make_chart()
    lost = chart.subjects[0].model_copy(
        update={"uncertainty": None, "state": "timeout", "message": "no answer", "findings": []})
    document.write(chart.model_copy(update={"subjects": [lost], "growths": []}), folder / FILE)
    html = reports.build(folder, tmp_path / "html").parent
    assert "No answer" in (html / "speed.html").read_text(encoding="utf-8")
    assert "No answer" in (html / "speed" / "figure-05-sphere.html").read_text(encoding="utf-8")
