"""The benchmark's logic: turns, ratios, bars, what was accepted. Nothing here is timed."""

import contextlib
import json
import math

import pytest

from raytruth.cli import main
from raytruth.comparisons import document
from raytruth.comparisons.bench import cases, measure
from raytruth.comparisons.bench import document as accepted
from raytruth.comparisons.bench.cases import Options
from raytruth.comparisons.bench.document import Bench, Row
from raytruth.comparisons.bench.text import line
from raytruth.comparisons.bench.timing import Contestant, Cost, Measured, interleave, judged, row
from raytruth.comparisons.execution.machine import machine
from raytruth.reference_tracer.errors import InputError
from raytruth.reference_tracer.scene import library


def contestant(name, costs, log, compiles=False):
    left = iter(costs)

    def run():
        log.append(name)
        return Cost(*next(left))

    return Contestant(name, run, compiles)


def test_contestants_take_turns_and_compilation_stands_apart():
    log = []
    measured = interleave([contestant("fast", [(9, 9), (1, 2), (1, 2)], log, compiles=True),
                           contestant("slow", [(4, 8), (6, 6)], log)], turns=2, budget=60)
    assert log == ["fast", "fast", "slow", "fast", "slow"]  # the first one compiles
    assert measured.first == {"fast": 9}
    assert [c.wall for c in measured.costs["fast"]] == [1, 1]


def test_a_turn_that_would_end_too_late_does_not_begin():
    log = []
    interleave([contestant("a", [(1, 1)] * 5, log)], turns=5, budget=0)
    assert log == ["a"]


def measured_as(fast, slow, others=0.0):
    return Measured({"fast": [Cost(*c) for c in fast], "slow": [Cost(*c) for c in slow]}, {}, others)


def test_ratios_are_taken_turn_by_turn():
    # the machine halves its speed in the second turn: the ratio of each turn does not notice
    measured = measured_as(fast=[(1, 2), (2, 4), (1, 2)], slow=[(10, 30), (20, 60), (11, 33)])
    found = measured.ratio("slow", "fast", "wall")
    assert (found.low, found.median, found.high) == (10, 10, 11)
    assert measured.ratio("slow", "fast", "cpu").median == 15


@pytest.mark.parametrize("others, clock, value", [(0.0, "wall", 10), (1.0, "cpu", 15)])
def test_processor_time_decides_where_others_are_busy(others, clock, value):
    found = row("k", "what", measured_as([(1, 2)], [(10, 30)], others), "slow", "fast", bar=12)
    assert (found.clock, found.value, found.holds) == (clock, value, value >= 12)


def test_the_clock_can_be_chosen():
    assert row("k", "what", measured_as([(1, 2)], [(10, 30)]), "slow", "fast", 12, "cpu").value == 15


@pytest.mark.parametrize("sense, value, holds", [
    (">=", 4.0, True), (">=", 3.9, False), ("<=", 4.0, True), ("<=", 4.1, False)])
def test_bars(sense, value, holds):
    assert judged(Row(key="k", what="w", bar=4.0, sense=sense, value=value)).holds is holds


def bench(*rows, processor=None):
    of = machine()
    on = of.model_copy(update={"processor": processor or of.processor})
    return Bench(created="now", seconds=1, machine=on, rows=rows)


def ratio_row(value, key="g/a", **more):
    return row(key, "what", measured_as([(1, 1)], [(value, 2 * value)]), "slow", "fast", None, **more)


@pytest.fixture
def kept(tmp_path):
    path = tmp_path / "accepted.json"
    small = Row(key="g/small", what="w", unit="s", sense="<=", value=1.0)
    accepted.accept(bench(ratio_row(10), ratio_row(2, key="g/b", sense="<="), small), None, path)
    return path


@pytest.mark.parametrize("now, falls", [(8.6, 0), (8.4, 1), (30, 0)])
def test_a_ratio_may_keep_85_percent(kept, now, falls):
    found = accepted.falls(bench(ratio_row(now)), accepted.read_accepted(kept))
    assert [f.key for f in found] == ["g/a"] * falls


@pytest.mark.parametrize("now, falls", [(2.3, 0), (2.4, 1), (0.1, 0)])
def test_where_less_is_better_more_is_a_fall(kept, now, falls):
    found = accepted.falls(bench(ratio_row(now, key="g/b", sense="<=")), accepted.read_accepted(kept))
    assert [f.key for f in found] == ["g/b"] * falls


def test_the_same_clock_is_compared(kept):
    # by processor time 20 was accepted: 12 by that clock is a fall, though 12 by wall would not be
    by_cpu = row("g/a", "what", measured_as([(1, 1)], [(12, 12)]), "slow", "fast", None, "cpu")
    assert len(accepted.falls(bench(by_cpu), accepted.read_accepted(kept))) == 1


def test_seconds_of_another_processor_are_not_compared(kept):
    slow = Row(key="g/small", what="w", unit="s", sense="<=", value=3.0)
    assert len(accepted.falls(bench(slow), accepted.read_accepted(kept))) == 1
    assert accepted.falls(bench(slow, processor="another"), accepted.read_accepted(kept)) == []


def test_pictures_of_another_size_are_not_compared(kept):
    assert accepted.falls(bench(ratio_row(1, picture="64 x 48")), accepted.read_accepted(kept)) == []


def test_accepting_some_rows_keeps_the_others(kept):
    accepted.accept(bench(ratio_row(20)), accepted.read_accepted(kept), kept)
    rows = accepted.read_accepted(kept).rows
    assert rows["g/a"].wall == 20 and rows["g/b"].wall == 2 and rows["g/small"].value == 1.0


def test_a_case_that_failed_is_neither_accepted_nor_a_fall(kept):
    failed = Row(key="g/a", what="w", state="missing", message="no compiler")
    assert accepted.falls(bench(failed), accepted.read_accepted(kept)) == []
    accepted.accept(bench(failed), accepted.read_accepted(kept), kept)
    assert accepted.read_accepted(kept).rows["g/a"].wall == 10
    assert "missing: no compiler" in line(failed)


def test_documents_survive_writing(tmp_path):
    before = bench(ratio_row(10))
    document.write(before, tmp_path / "bench.json")
    assert document.read(tmp_path / "bench.json", Bench, "c") == before
    assert json.loads((tmp_path / "bench.json").read_text())["rows"][0]["wall"]["median"] == 10


def test_pictures_shrink_to_the_rays_allowed():
    whole = library.scene("figure-17-scene1").camera
    for options, most in ((Options(), 640 * 480), (Options(quick=True), 640 * 480 / 4)):
        scene = options.sized("figure-17-scene1", 640 * 480)
        rays = scene.camera.width * scene.camera.height
        assert math.isclose(rays, most, rel_tol=0.01)
        assert math.isclose(scene.camera.width / scene.camera.height, whole.width / whole.height, rel_tol=0.01)
    many = Options().sized("figure-03-256-samples", 640 * 480)
    assert math.isclose(many.camera.width * many.camera.height * 256, 640 * 480, rel_tol=0.05)
    assert Options(size="own").sized("figure-17-scene1", 10).camera == whole
    assert Options(size="31x20").sized("figure-17-scene1", 10).camera.width == 31


def test_every_group_says_what_it_measures():
    for name, group in cases.GROUPS.items():
        assert group.name == name and group.cases and group.about
    with pytest.raises(InputError, match="unknown group 'nonsense'"):
        cases.find(["nonsense"])
    with pytest.raises(InputError, match="no case is called 'nonsense'"):
        measure.chosen(cases.find([]), ["nonsense"])


def test_a_real_run_end_to_end(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(accepted, "ACCEPTED", tmp_path / "accepted.json")
    asked = ["--only", "exact-vs-paper", "--scenes", "figure-05-sphere", "--turns", "2", "--size", "64x48"]
    assert main(["bench", *asked, "--accept", "-o", str(tmp_path)]) == 0
    made = document.read(tmp_path / "bench.json", Bench, "c").rows
    assert [r.key for r in made] == ["exact-vs-paper/figure-05-sphere"]
    assert made[0].turns == 2 and made[0].seconds["exact"].wall > 0
    told = json.loads((tmp_path / "accepted.json").read_text())
    told["rows"]["exact-vs-paper/figure-05-sphere"] |= {"wall": 1e6, "cpu": 1e6}
    (tmp_path / "accepted.json").write_text(json.dumps(told))
    assert main(["bench", *asked]) == 1
    assert "SLOWER: exact-vs-paper/figure-05-sphere" in capsys.readouterr().out


@pytest.mark.parametrize("arguments, said", [(["--turns", "0"], "--turns"), (["--size", "1x"], "--size"),
                                             (["--only", "x"], "group"), (["-o", __file__], "test_bench.py")])
def test_input_errors_are_one_sentence(arguments, said, capsys):
    with contextlib.suppress(SystemExit):  # argparse's own way to end
        assert main(["bench", *arguments]) == 2
    error = capsys.readouterr().err
    assert said in error and error.count("\n") == 1
