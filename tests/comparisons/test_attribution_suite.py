"""Attributions in child processes: kept by content, a crash costs one; the suite explains what differs."""

import sys

import pytest

from raytruth.comparisons import suite
from raytruth.comparisons.attribution import cases, document, measure
from raytruth.comparisons.attribution.measure import Task, make_all
from raytruth.comparisons.execution import pool
from raytruth.comparisons.execution.pool import Pool
from raytruth.comparisons.results import Gate
from raytruth.reference_tracer.scene import library
from raytruth.reference_tracer.tracer.optics import Optics
from raytruth.reference_tracer.tracer.world import World

SCENE = library.scene("effect-mixing").resized(40, 30)
CRASH = (sys.executable, "-c", "import os, sys; sys.stdin.readline(); os.abort()")


def test_a_fault_is_found_and_named_in_a_child_and_made_once(tmp_path, monkeypatch):
    wrong_one, right_one = Task(SCENE, "exact", fault="no-1-minus-r"), Task(SCENE, "exact", fault="")
    with Pool(1) as made:
        answers = make_all([wrong_one, right_one], tmp_path, made)
    assert answers[wrong_one].judged.found and answers[wrong_one].judged.attribution.stage == "mixing"
    assert not answers[right_one].judged.found and answers[right_one].judged.attribution.stage is None

    monkeypatch.setattr(pool, "COMMAND", CRASH)  # nothing is left to be made; what is new crashes alone
    other = Task(SCENE, "exact", fault="shadow-once")
    with Pool(1) as made:
        again = make_all([wrong_one, other], tmp_path, made)
    assert again[wrong_one] == answers[wrong_one]
    assert again[other].state == "crashed" and again[other].judged is None


def test_every_difference_is_another_task():
    tasks = [Task(SCENE, "exact"), Task(SCENE, "paper"), Task(SCENE, "exact", "paper"), Task(SCENE, "exact", fault=""),
             Task(SCENE, "exact", fault="y-flipped"), Task(SCENE.resized(41, 30), "exact")]
    assert len({task.key for task in tasks}) == len(tasks)


def test_the_table_lists_every_fault_and_the_right_tracer_on_every_effect(tmp_path, monkeypatch):
    monkeypatch.setattr(pool, "COMMAND", CRASH)
    monkeypatch.setattr(measure, "JUDGES", ("exact", "no-such-renderer"))
    written = measure.wrong_on_purpose(tmp_path, jobs=2)
    assert document.read(tmp_path) == written
    assert [row.id for row in written.rows] == [*cases.FAULTS, *["right"] * len(library.effects())]
    assert [j.renderer for row in written.rows for j in row.judgements] == ["exact"] * len(written.rows)
    assert not any(row.holds for row in written.rows)  # who crashed has found nothing


def test_a_comparison_that_differs_is_told_where(tmp_path, monkeypatch):
    broken = Gate(name="color p99", value=1.0, limit=0.0, holds=False, means="any limit")
    monkeypatch.setattr(suite, "judge", lambda *_: ("differs", "a limit nobody can keep", [broken]))
    options = suite.Options(tmp_path, renderers=("mitsuba-native",), with_studies=False)
    comparison, = suite.compare([SCENE], options).comparisons
    assert comparison.verdict == "differs"
    assert comparison.attribution.stage is None and "No stage diverges" in comparison.attribution.sentence
    assert comparison.attribution.b.startswith("Mitsuba 3, native")


@pytest.mark.parametrize("fault", cases.FAULTS.values(), ids=lambda fault: fault.id)
def test_every_fault_replaces_what_the_tracer_has(fault):
    """A formula or a query of another name would change nothing."""
    if fault.world.optics is World.optics:
        changed = vars(fault.world).keys() & vars(World).keys()
    else:
        changed = vars(type(fault.world.optics)).keys() & vars(Optics).keys()
    assert changed - {"__module__", "__doc__"} and fault.right != fault.wrong
