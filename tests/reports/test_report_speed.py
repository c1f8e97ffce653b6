"""Speed against accuracy: where points stand, what the frontier is, and the pages."""

import csv

from report_support import HOSTILE, make_results

from raytruth import reports
from raytruth.comparisons import document
from raytruth.comparisons.bench.document import Spread
from raytruth.comparisons.charting.document import (
    FILE,
    Accuracy,
    Chart,
    Growth,
    GrowthLine,
    GrowthPoint,
    Point,
    Series,
    Subject,
    Times,
    Uncertainty,
)
from raytruth.reference_tracer.scene import library
from raytruth.reports.pages.speed import KINDS, Speed


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


def lines(document: Chart, kind="wrong"):
    """The lines of the first subject's chart of that kind, and its frontier."""
    speed = Speed(document)
    _x, _y, found, best = speed.drawn(document.subjects[0], next(k for k in KINDS if k.id == kind))
    return {line.label: line for line in found}, best


def test_the_frontier_leaves_out_controls_and_what_is_beaten():
    found, best = lines(make_chart(*ALL))
    # 0.8 s for no wrong pixel is beaten by exact's 0.3 s; the crude control is cheapest and does not count
    assert best == [(100, 300), (200, 30), (300, 0)]
    assert found["crude"].style == "muted" and found["crude"].points == [(50, 900)]
    entries = Speed(make_chart(*ALL)).subjects[0].entries
    assert [(e.series.id, e.point.label) for e in entries if e.best] == [
        ("paper", "h 0.1"), ("paper", "h 0.05"), ("exact", "")]


def test_an_error_that_rounding_explains_beats_nobody():
    found, best = lines(make_chart(series("a", point(0.1, depth=1e-13)), series("b", point(0.2, depth=0.0))), "depth")
    assert best == [(100, 1e-13)] and set(found) == {"a", "b"}


def test_a_failure_has_no_point_in_a_chart_and_its_reason_in_the_table():
    found, _ = lines(make_chart(*ALL))
    assert "other" not in found
    assert any(e.point.message.startswith("signal 11") for e in Speed(make_chart(*ALL)).subjects[0].entries)


def test_the_clock_of_a_busy_machine_is_the_processors():
    quiet, busy = make_chart(EXACT), make_chart(series("exact", point(0.3, others=1.5)))
    assert (Speed(quiet).clock, Speed(busy).clock) == ("wall", "cpu")
    assert lines(quiet)[0]["exact"].points == [(300, 0)] and lines(busy)[0]["exact"].points == [(600, 0)]
    assert lines(quiet)[0]["exact"].spread == [(150, 600)]
    assert Speed(busy).growth(busy.growths[0], False)[1].label.startswith("wall")  # threads can only be told apart by it


def test_series_of_a_method_share_a_colour_and_differ_in_their_filling():
    found, _ = lines(make_chart(STEPS, series("paper-32", point(1.0), method="paper"), EXACT, CRUDE))
    assert found["paper"].number == found["paper-32"].number != found["exact"].number
    assert [found[id].style for id in ("paper", "paper-32", "exact")] == ["marks", "hollow", "marks"]


def test_efficiency_has_a_linear_axis_from_nothing_to_all():
    speed = Speed(make_chart(EXACT))
    _, y, found = speed.growth(speed.chart.growths[0], True)
    assert y.range == (0.0, 1.0) and found[0].points == [(1, 1), (2, 0.5), (4, 0.25)]
    assert speed.growth(speed.chart.growths[0], False)[1].step is None  # times are logarithmic


def test_the_headline_says_of_which_subject_it_speaks():
    assert Speed(make_chart(*ALL)).headline == "Ball: all is well"


def test_the_pages_are_there_only_with_their_document(folder, tmp_path):
    html = reports.build(folder, tmp_path / "html").parent
    assert not (html / "speed.html").exists() and not (html / "speed").exists()
    document.write(make_chart(*ALL, title=f"Ball {HOSTILE}", finding=f"found {HOSTILE}"), folder / FILE)
    reports.build(folder, html)
    overview = (html / "speed.html").read_text(encoding="utf-8")
    subject = (html / "speed" / "figure-05-sphere.html").read_text(encoding="utf-8")
    for page in (overview, subject):
        assert HOSTILE not in page and page.count("<script") == 1
        assert "<svg class=\"chart\"" in page
    assert "1 point without a result" in overview and "signal 11" in overview
    assert 'href="speed/figure-05-sphere.html"' in overview and 'href="../speed.html"' in subject
    for words in ("crashed: signal 11", "h 0.05", "two cores"):
        assert words in subject or words in overview
    assert subject.count("<svg class=\"chart\"") == 8
    assert 'href="speed.html"' in (html / "index.html").read_text(encoding="utf-8")


def test_the_numbers_behind_the_charts_are_a_table_for_other_programs(folder, tmp_path):
    document.write(make_chart(*ALL, series("=1+1", point(0.4, 5))), folder / FILE)
    html = reports.build(folder, tmp_path / "html").parent
    for page, link in (("speed/figure-05-sphere.html", "speed/figure-05-sphere.csv"), ("speed.html", "growth-pixels.csv")):
        assert f'{link}" download' in (html / page).read_text(encoding="utf-8")
    rows = list(csv.DictReader((html / "speed/figure-05-sphere.csv").open(encoding="utf-8", newline="")))
    of = {(row["series"], row["label"]): row for row in rows}
    assert len(rows) == 7 and of["paper", "h 0.05"]["accuracy.wrong"] == "30"
    assert float(of["paper", "h 0.01"]["picture.wall.high"]) == 1.6
    assert of["other", ""]["message"] == f"signal 11 {HOSTILE}" and of["other", ""]["accuracy.wrong"] == ""
    assert ("'=1+1", "") in of  # no spreadsheet computes a name
    grown = list(csv.DictReader((html / "growth-pixels.csv").open(encoding="utf-8", newline="")))
    assert [row["x"] for row in grown] == ["1.0", "2.0", "4.0"] and grown[2]["picture.wall.median"] == "0.25"


def test_a_subject_without_a_truth_says_why(folder, tmp_path):
    chart = make_chart()
    lost = chart.subjects[0].model_copy(
        update={"uncertainty": None, "state": "timeout", "message": "no answer", "findings": []})
    document.write(chart.model_copy(update={"subjects": [lost], "growths": []}), folder / FILE)
    html = reports.build(folder, tmp_path / "html").parent
    assert "No answer" in (html / "speed.html").read_text(encoding="utf-8")
    assert "No answer" in (html / "speed" / "figure-05-sphere.html").read_text(encoding="utf-8")
