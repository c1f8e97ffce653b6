"""Order and count of cases."""

import math

import pytest
from report_support import make_comparison, make_results, make_run

from raytruth.comparisons.results import Gate
from raytruth.reference_tracer.errors import InputError
from raytruth.reference_tracer.scene import library
from raytruth.reports.cases import cases, failed_runs, is_lower_bound, verdict_counts


@pytest.fixture
def results():
    return make_results(library.scene("figure-05-sphere"))


def gate(value, limit, holds) -> Gate:
    return Gate(name="g", value=value, limit=limit, holds=holds, means="")


def test_worst_comes_first(results):
    verdicts = [case.comparison.verdict for case in cases(results)]
    assert verdicts == ["differs", "not compared", "expected", "agrees", "agrees"]


def test_among_differing_ones_the_farthest_beyond_its_limit_comes_first(results):
    gates = {"twice": [gate(2e-3, 1e-3, False)], "nan": [gate(math.nan, 1e-3, False)],
             "hundredfold": [gate(0.1, 1e-3, False), gate(0.0, 1e-3, True)], "from nothing": [gate(3, 0, False)]}
    comparisons = [make_comparison(id, "bad", "differs").model_copy(update={"gates": g}) for id, g in gates.items()]
    order = [c.comparison.id for c in cases(results.model_copy(update={"comparisons": comparisons}))]
    assert order == ["from nothing", "nan", "hundredfold", "twice"]


def test_the_direction_of_a_limit_follows_from_value_and_verdict():
    assert not is_lower_bound(gate(1e-4, 1e-3, True)) and not is_lower_bound(gate(1e-2, 1e-3, False))
    assert is_lower_bound(gate(40, 30, True)) and is_lower_bound(gate(20, 30, False))
    assert not any(is_lower_bound(gate(value, 1.0, False)) for value in (None, math.nan, math.inf, 1.0))


def test_counts_equal_the_documents_and_failures_stay_in_the_denominator(results):
    counts = verdict_counts(cases(results))
    assert counts == {"differs": 1, "not compared": 1, "expected": 1, "agrees": 2}  # the crashed run is not compared
    assert sum(counts.values()) == len(results.comparisons)


def test_runs_without_a_picture_are_gathered_by_reason(results):
    more = [make_run(key, state="missing", message="install it").model_copy(update={"title": "R", "scene": scene})
            for key, scene in (("x", "figure-05-sphere"), ("y", "another"), ("z", "another"))]  # one of two settings: once
    found = failed_runs(results.model_copy(update={"runs": results.runs + more}))
    assert [(a.renderer, a.state.word, len(a.scenes)) for a in found] == [
        ("Renderer crash", "Crashed", 1), ("R", "Missing", 2), ("Renderer refused", "Refused", 1)]


@pytest.mark.parametrize("change, words", [
    ({"comparisons": [make_comparison("x", "nobody", "agrees")]}, "'x' names run 'nobody'"),
    ({"comparisons": [make_comparison("x", "good", "agrees").model_copy(update={"scene": "s"})]},
     "'x' names scene 's'"),
    ({"runs": [make_run("good"), make_run("good")]}, "run 'good' is listed 2 times"),
])
def test_a_document_that_contradicts_itself_is_refused_in_one_line(results, change, words):
    with pytest.raises(InputError) as caught:
        cases(results.model_copy(update=change))
    assert words in str(caught.value) and "\n" not in str(caught.value)
