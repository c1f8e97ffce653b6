"""Two runs: what is better, worse, slower, faster, new and gone."""

import pytest
from report_support import HOSTILE, make_comparison, make_results, make_run

from raytruth import reports
from raytruth.comparisons import results as documents
from raytruth.comparisons.results import Results, Timing
from raytruth.reference_tracer.scene import library
from raytruth.reports.pages import arrange
from raytruth.reports.pages.changes import changes


def with_cases(*cases: tuple[str, str, float, float]) -> Results:
    """Comparisons by name, verdict, error of colour and seconds."""
    results = make_results(library.scene("figure-05-sphere"))
    runs = [make_run("good"), *(make_run(name).model_copy(update={"timing": Timing(warm=seconds)})
                                for name, _, _, seconds in cases)]
    comparisons = [make_comparison(name, name, verdict).model_copy(update={"metrics": {"color p99": error}})
                   for name, verdict, error, _ in cases]
    return results.model_copy(update={"runs": runs, "comparisons": comparisons})


@pytest.mark.parametrize("before, now, kinds", [
    (("agrees", 1e-3, 1.0), ("agrees", 1e-3, 1.0), []),
    (("agrees", 1e-3, 1.0), ("differs", 1e-3, 1.0), ["worse"]),
    (("differs", 1e-3, 1.0), ("agrees", 0.5, 1.0), ["better"]),  # the verdict outranks the error
    (("agrees", 1e-3, 1.0), ("agrees", 2.1e-3, 1.6), ["worse", "slower"]),
    (("agrees", 2.1e-3, 1.6), ("agrees", 1e-3, 1.0), ["better", "faster"]),
    (("agrees", 1e-3, 1.0), ("agrees", 1.9e-3, 1.4), []),
    (("agrees", 0.0, 1.0), ("agrees", 1e-16, 1.0), ["worse"]),  # from exact equality to any difference
])
def test_a_change_is_told_by_verdict_error_and_time(before, now, kinds):
    report = arrange(with_cases(("x", *now)), earlier=with_cases(("x", *before)))
    assert [change.kind for change in changes(report)] == kinds


def test_what_is_new_or_gone_is_told():
    same = ("same", "agrees", 1e-3, 1.0)
    report = arrange(with_cases(same, ("new", "agrees", 1e-3, 1.0)), earlier=with_cases(same, ("old", "agrees", 1e-3, 1.0)))
    assert [(change.kind, change.id) for change in changes(report)] == [("new", "new"), ("gone", "old")]


def test_the_page_is_there_only_against_an_earlier_run(folder, tmp_path):
    earlier = tmp_path / "earlier"
    earlier.mkdir()
    lost = make_comparison(f"lost {HOSTILE}", "good", "agrees")
    results = make_results(library.scene("figure-05-sphere"))
    documents.write(results.model_copy(update={"comparisons": [*results.comparisons, lost]}), earlier)
    assert not (reports.build(folder, tmp_path / "html").parent / "changes.html").exists()
    index = reports.build(folder, tmp_path / "html", against=earlier)
    text = (index.parent / "changes.html").read_text(encoding="utf-8")
    assert "<b>1 gone</b>" in text and "lost &lt;script&gt;" in text and "<script>alert" not in text
    assert "1 gone." in index.read_text(encoding="utf-8")
    reports.build(folder, tmp_path / "html")  # without it again: the page goes
    assert not (index.parent / "changes.html").exists()
