"""Failure maps: what a cell says, which cell stands for a method, laws against their bands, and the page."""

import json
import re

import pytest
from report_support import HOSTILE, make_results, marks_of

from raytruth import reports
from raytruth.comparisons.stability import document as documents
from raytruth.comparisons.stability.document import (
    KINDS,
    FamilyRecord,
    Finding,
    LawPoint,
    LawRecord,
    MethodRecord,
    Point,
    Series,
    Stability,
)
from raytruth.reference_tracer.errors import InputError
from raytruth.reference_tracer.scene import library
from raytruth.reports.build import STATIC, environment, static
from raytruth.reports.pages.stability import LEAST_SHARE, LETTERS, failures, law_lines, laws

VALUES = [0.1, 0.01, 0.001, 0.0]


def point(**counts) -> Point:
    return Point(counts={kind.replace("_", " "): n for kind, n in counts.items()}, worst_error=1e-9, evaluations=12.5)


def law(method="steps", measured=(0.0, 0.25, 1.0, 1.0), expected=(0.0, 0.3, 1.0, 1.0), holds=True) -> LawRecord:
    points = [LawPoint(value=v, expected=e, low=max(e - 0.1, 0), high=min(e + 0.1, 1), measured=m,
                       within=abs(m - e) <= 0.1) for v, e, m in zip(VALUES, expected, measured)]
    curve = [(0.1, expected[0]), (0.001, expected[2])]
    return LawRecord(method=method, sentence="1 - p", kinds=["missed"], curve=curve, points=points, holds=holds)


def family(id="grazing", laws=(), **rows) -> FamilyRecord:
    series = [Series(method=name, precision=64, points=points) for name, points in rows.items()]
    return FamilyRecord(id=id, title=f"Family {id}", parameter="depth", values=VALUES, values_single=[], labels=[],
                        when="often", why=f"because {HOSTILE}", instead="other", series=series, laws=list(laws))


def document(*families: FamilyRecord, findings=()) -> Stability:
    names = dict.fromkeys(s.method for f in families for s in f.series)
    return Stability(created="2025", seconds=1, machine=make_results(library.scene("figure-05-sphere")).machine, seed=1,
                     rays=4, confidence=0.9999, kinds=KINDS, families=list(families), findings=list(findings),
                     methods=[MethodRecord(name=n, title=n, claims=n == "sure",
                                           wrong_variant="made to fail" if n == "bad" else "") for n in names])


GOOD = [point(correct=4)] * 4
STEPS = [point(correct=4), point(correct=3, missed=1), point(missed=3, wrong_root=1), point(missed=4)]
SHY = [point(correct=4), point(correct=3, false=1), point(undecided=4), Point(counts={})]


def test_every_kind_has_a_letter_of_its_own_and_a_colour_in_both_themes():
    assert set(LETTERS) == set(KINDS)
    assert len(set(LETTERS.values())) == len(LETTERS)
    style = static(environment())[STATIC[0]]
    for kind in set(KINDS) - {"correct"}:
        name = kind.replace(" ", "-")
        assert f".k-{name} {{ --kind: var(--k-{name}); }}" in style
        assert len(re.findall(rf"--k-{name}: #", style)) == 2


def test_a_cell_is_filled_by_the_share_that_is_not_correct():
    arranged = failures(document(family(steps=STEPS)))
    cells = arranged.families[0].maps[0].rows[0].cells
    assert [c.letter for c in cells] == ["", "M", "M", "M"]
    assert [c.fill for c in cells] == [0, pytest.approx(100 * (LEAST_SHARE + (1 - LEAST_SHARE) / 4), abs=0.1), 100, 100]
    assert cells[2].text == "p = 10⁻³: 75 % missed, 25 % wrong root; largest error 10⁻⁹; 12.5 evaluations a ray"


def test_a_wrong_answer_outranks_any_number_of_undecided_ones_in_the_overview():
    arranged = failures(document(family(shy=SHY, good=GOOD)))
    cells = dict(zip([m.name for m in arranged.methods], arranged.overview[0][1]))
    assert (cells["shy"].kind, cells["shy"].text) == ("false", "shy: 25 % wrong at p = 0.01")
    assert cells["good"].kind == "correct" and cells["good"].fill == 0


def test_what_does_not_apply_is_neither_right_nor_wrong():
    arranged = failures(document(family(shy=SHY), family("other", good=GOOD)))
    last = arranged.families[0].maps[0].rows[0].cells[-1]
    assert (last.style, last.letter, last.fill) == ("none", "", 0)
    assert arranged.overview[1][1][0].style == "none"  # "shy" was not run on the other family


def test_families_with_findings_come_first_and_variants_are_no_columns():
    finding = Finding(what="wrong and not flagged", family="b", method="sure", values=[0.0], rates=[1.0],
                      kinds=["missed"], sentence="sure is wrong")
    arranged = failures(document(family("a", sure=GOOD, bad=STEPS), family("b", sure=STEPS), findings=[finding]))
    assert [f.record.id for f in arranged.families] == ["b", "a"]
    assert [m.name for m in arranged.methods] == ["sure"]
    assert arranged.families[1].variants == {"bad": "made to fail"}


def test_a_law_runs_from_easy_to_hard_and_a_zero_lies_beyond_the_axis():
    svg = laws(family(laws=[law()]))[0].chart
    # p falls, so the axis is turned round; line 2 is what was measured, and the band of bars has no name
    x, y = zip(*marks_of(svg, "law-grazing-0-2"))
    assert list(x) == sorted(x)
    assert x[1] - x[0] == pytest.approx(x[2] - x[1], abs=0.05)  # 0.1, 0.01, 0.001: equal ratios
    assert x[3] > x[2]  # p = 0
    assert y[1] == pytest.approx(y[0] + 0.25 * (y[2] - y[0]), abs=0.05)  # a quarter stands a quarter of the way up
    _theory, bars, _measured = law_lines([law()])
    assert all(low < high for low, high in bars.spread) and bars.points[1] == (0.01, 0.3)


def test_a_measurement_outside_its_band_is_crossed_out_and_its_law_comes_first():
    broken = law(measured=(0.0, 0.6, 1.0, 1.0), holds=False)
    found = laws(family(laws=[law("calm"), broken]))
    assert [entry.holds for entry in found] == [False, True]
    assert law_lines([broken])[2].off == [False, True, False, False] and not any(law_lines([law()])[2].off)
    assert "var(--differs)" in found[0].chart and "var(--differs)" not in found[1].chart


def test_methods_that_obey_the_same_law_share_a_chart_and_equal_measurements_their_marks():
    found = laws(family(laws=[law("a"), law("b"), law("c", measured=(0.0, 0.3, 1.0, 1.0))]))
    assert [entry.methods for entry in found] == [("a", "b", "c")]
    assert "a, b</text>" in found[0].chart and "c</text>" in found[0].chart


@pytest.mark.parametrize("rate", [0.0, 1.0])
def test_a_rate_that_never_changes_is_a_sentence(rate):
    same = (rate,) * 4
    entry = laws(family(laws=[law(expected=same, measured=same)]))[0]
    assert entry.chart is None and entry.always == rate
    other = (rate, rate, rate, abs(rate - 0.25))  # one point off, and it is drawn
    assert laws(family(laws=[law(expected=same, measured=other, holds=False)]))[0].chart is not None


def test_the_page_is_there_only_with_its_document(folder, tmp_path):
    html = reports.build(folder, tmp_path / "html").parent
    assert not (html / "stability.html").exists()
    assert not any("stability.html" in page.read_text() for page in html.rglob("*.html"))
    finding = Finding(what="law broken", family="nobody", method="steps", values=[0.1], rates=[1.0], kinds=["missed"],
                      sentence=f"steps breaks it {HOSTILE}", example={"o": [0, 1, 2]})
    documents.keep(document(family(steps=STEPS, shy=SHY, laws=[law()]), findings=[finding]), folder)
    reports.build(folder, html)
    page = (html / "stability.html").read_text(encoding="utf-8")
    assert page.index("steps breaks it") < page.index("Family grazing")  # findings first
    assert HOSTILE not in page and page.count("<script") == 1
    for words in ("When it fails", "often.", "Use instead", "other.", "<svg class=\"chart\""):
        assert words in page
    assert 'href="stability.html"' in (html / "index.html").read_text(encoding="utf-8")


@pytest.mark.parametrize("text, words", [("no document", "not a stability document"), ("[]", "not a stability document"),
                                        (json.dumps({"version": 99}), "has version 99"),
                                        (json.dumps({"version": 1}), "created: ")])
def test_a_bad_document_is_told_in_one_sentence_and_leaves_the_report(folder, tmp_path, text, words):
    html = reports.build(folder, tmp_path / "html").parent
    (folder / documents.FILE).write_text(text)
    with pytest.raises(InputError) as caught:
        reports.build(folder, html)
    assert words in str(caught.value) and "\n" not in str(caught.value)
    assert (html / "index.html").exists()
