"""The effects one by one: who checked each, which faults were noticed, where two renderers part."""

import pytest
from report_support import HOSTILE, make_results

from raytruth import reports
from raytruth.comparisons import document
from raytruth.comparisons import results as documents
from raytruth.comparisons.attribution.document import (
    FILE,
    Attribution,
    Evidence,
    History,
    Judgement,
    Ray,
    Table,
    WorstPixel,
    WrongOnPurpose,
)
from raytruth.reference_tracer.scene import library
from raytruth.reports.pages.evidence import CHECKED, PREFIX


def attribution(stage="shadow") -> Attribution:
    ray = Ray(generation=0, kind="camera", object=f"ball {HOSTILE}", t=2.5, point=(1.0, 2.0, 3.0), normal=None, lights=1,
              weight=1.0, color=(0.25, 0.5, 0.75))
    pixel = WorstPixel(row=7, col=9, difference=0.125, color_a=(0.0, 0.0, 0.0), color_b=(1.0, 1.0, 1.0),
                       a=History(renderer="left", rays=[ray]), b=History(renderer="right", rays=[], note="tells nothing"))
    return Attribution(scene="effect-shadow", a="left", b="right", width=32, height=24, stage=stage,
                       sentence=f"they part at {stage} {HOSTILE}", shown_on="white objects",
                       evidence=[Evidence(stage="camera", questions=["rays?"], outcome="agrees", pixels=768),
                                 Evidence(stage="shadow", questions=["dark?"], outcome="diverges", pixels=768,
                                          diverging=31)],
                       pixels=[pixel] if stage else [])


def judged(found: bool, stage) -> Judgement:
    return Judgement(renderer="judge", title="Renderer judge", state="ok", found=found, reason="a limit",
                     attribution=attribution(stage))


def fault(judgement: Judgement, expected="shadow") -> WrongOnPurpose:
    return WrongOnPurpose(id="slip", title=f"a slip {HOSTILE}", effect="effect-shadow", right="a < b", wrong="a > b",
                          expected=expected, because="it matters", judgements=[judgement])


def table(*rows: WrongOnPurpose) -> Table:
    return Table(width=32, height=24, rows=list(rows), command="raytruth attribute --wrong-on-purpose")


@pytest.fixture
def built(folder, tmp_path):
    """A function that builds the report of the effect of shadows with a table of faults; returns its folder."""
    results = make_results(library.scene("figure-05-sphere"))
    scene = results.scenes[0].model_copy(update={"name": "effect-shadow"})
    comparisons = [c.model_copy(update={"scene": "effect-shadow", "metrics": {"color p99": 2e-5, "color max": 7.0},
                                        "attribution": attribution() if c.verdict == "differs" else None})
                   for c in results.comparisons]
    runs = [r.model_copy(update={"scene": "effect-shadow"}) for r in results.runs]
    documents.write(results.model_copy(update={"scenes": [scene], "runs": runs, "comparisons": comparisons}), folder)

    def build(rows: Table | None):
        if rows:
            document.write(rows, folder / FILE)
        return reports.build(folder, tmp_path / "html").parent
    return build


def text(path) -> str:
    return path.read_text(encoding="utf-8")


def test_every_effect_of_the_library_has_words():
    assert [PREFIX + checked.id for checked in CHECKED] == list(library.effects())


def test_the_page_of_an_effect_says_who_checked_it_and_how_closely(built):
    html = built(table(fault(judged(True, "shadow"))))
    page, overview = text(html / "evidence/shadow.html"), text(html / "evidence.html")
    for shown in (page, overview):
        assert "(Renderer good)" in shown and "(Renderer bad)" in shown  # by whom
        assert "(Renderer paper)" not in shown  # ours is no independent witness
        assert "section 4.3.1" in shown and "1 of 1 fault made on purpose was found" in shown
    assert 'href="evidence/shadow.html"' in overview and "found, named <b>shadow</b>" in overview
    assert "a &lt; b" in page and "a &gt; b" in page and "images/errors/" in page
    assert "<script>alert" not in page + overview


def test_a_parting_is_shown_with_the_rays_of_both_sides(built):
    html = built(table(fault(judged(True, "shadow"))))
    for page in (text(html / "evidence/shadow.html"), text(html / "scenes/effect-shadow.html")):
        assert "They part at shadow" in page and "Row 7, column 9" in page and "tells nothing" in page.lower()
        assert "0.25&ensp;0.5&ensp;0.75" in page and "<script>alert" not in page


@pytest.mark.parametrize("row, words", [
    (fault(judged(False, None)), "nothing found"), (fault(judged(True, "hit")), "named <b>hit</b>"),
    (fault(Judgement(renderer="judge", title="Renderer judge", state="missing", message="no judge here")), "missing")])
def test_a_fault_that_is_not_found_or_named_otherwise_does_not_count(built, row, words):
    assert not row.holds
    html = built(table(row))
    assert "0 of 1 fault made on purpose was found" in text(html / "evidence.html")
    assert words in text(html / "evidence/shadow.html")


def test_the_right_tracer_must_be_taken_for_nothing():
    right = fault(judged(False, None), expected=None)
    assert right.holds
    assert not fault(judged(True, None), expected=None).holds
    assert not fault(judged(False, "normal"), expected=None).holds


def test_without_the_faults_the_effects_still_have_their_pages(built):
    html = built(None)
    assert "made on purpose was" not in text(html / "evidence/shadow.html")
    assert "Wrong on purpose" not in text(html / "evidence.html")


def test_without_effects_there_are_no_such_pages(folder, tmp_path):
    html = reports.build(folder, tmp_path / "html").parent
    assert not (html / "evidence.html").exists() and not (html / "evidence").exists()
    assert "one by one" not in text(html / "index.html")
