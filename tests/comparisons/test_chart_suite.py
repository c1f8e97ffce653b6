"""The suite of charts: real measurements of a tiny scene, crashes that cost their own points, finished work reused."""

import json
import sys

import numpy as np
import pytest
from workers import exit_code

from raytruth.comparisons.charting import document as results
from raytruth.comparisons.charting import measure
from raytruth.comparisons.charting.cases import REFERENCE_SAMPLES, SWEEPS, Charted, Study, Sweep, chosen, studies
from raytruth.comparisons.execution import pool
from raytruth.reference_tracer.errors import InputError
from raytruth.reference_tracer.scene.load import parse_scene

SCENE = parse_scene(json.dumps({
    "name": "ball", "camera": {"width": 32, "height": 24}, "tracing": {"max_distance": 8},
    "objects": [{"surface": {"type": "sphere", "center": [0, 0, 3], "r": 1}}],
    "lights": [{"position": [2, 2, 0]}]}).encode())
BALL = Charted(SCENE, "surface")

CHOSEN = {sweep.id: sweep for sweep in SWEEPS}
PAPER = Sweep("paper", "paper", "paper", "first hits", "reference", {"method": "paper"}, "step_size", "step size",
              (1.3, 0.005), (1.3, 0.005))
ABSENT = Sweep("absent", "absent", "absent", "converter", "renderer-of-tomorrow")
SWEPT = (PAPER, CHOSEN["exact"], CHOSEN["interval"], ABSENT, CHOSEN["crude"], CHOSEN["oracle"])

CRASHING = """
import os, signal
from raytruth.comparisons.charting import competitors
from raytruth.comparisons.execution import worker
ours = competitors.Ours.run
def run(self, warm=False):
    if self.method == "interval":
        os.kill(os.getpid(), signal.SIGSEGV)
    return ours(self, warm)
competitors.Ours.run = run
worker.main()
"""
NOBODY = "raise SystemExit('nobody may be asked')"


@pytest.fixture
def nobody(monkeypatch):
    monkeypatch.setattr(pool, "COMMAND", (sys.executable, "-c", NOBODY))


@pytest.fixture(scope="module")
def charted(tmp_path_factory):
    folder = tmp_path_factory.mktemp("results")
    study = Study("samples", "Samples", "samples", (1, 16), lambda n: SCENE.resized(16, 12, samples=round(n**0.5)),
                  "error", (("exact", {"method": "exact"}),))
    options = measure.Options(folder, turns=2, limit=60.0)
    with pytest.MonkeyPatch.context() as patch:
        # Dr.Jit must not be imported before it is told where to keep kernels
        patch.setattr(pool, "COMMAND", (sys.executable, "-c", CRASHING))
        return folder, options, study, measure.run([BALL], [study], options, SWEPT)


def points(chart, id):
    return next(s for s in chart.subjects[0].series if s.id == id).points


def test_accuracy_and_cost_of_every_point(charted):
    _, _, _, chart = charted
    coarse, fine = points(chart, "paper")
    exact, = points(chart, "exact")
    oracle, = points(chart, "oracle")
    crude, = points(chart, "crude")
    hit = np.arcsin(1 / 3)  # the ball is seen within this angle of its centre
    row, col = np.mgrid[:24, :32]
    x, y = ((col + 0.5) - 16, (row + 0.5) - 12)
    seen = int((np.hypot(x, y) * 2 * np.tan(np.pi / 6) / 32 < np.tan(hit)).sum())
    assert crude.accuracy.wrong == seen  # one sample, behind the ball: it sees nothing of it
    assert 0 < coarse.accuracy.wrong < seen and fine.accuracy.wrong == exact.accuracy.wrong == 0
    assert (oracle.accuracy.wrong, oracle.accuracy.depth_max, oracle.accuracy.color_max) == (0, 0, 0)
    assert exact.accuracy.depth_max < 1e-13 and chart.subjects[0].uncertainty.depth_max < 1e-11
    for p in (coarse, fine, exact, crude):
        assert p.turns == 2 and 0 < p.picture.wall.low <= p.picture.wall.median <= p.picture.wall.high
        assert p.hits.cpu.median > 0 and p.peak_mib > 10
    assert fine.evaluations > coarse.evaluations > crude.evaluations
    assert exact.build is None and oracle.hits is None


def test_a_crash_costs_its_own_points_and_what_is_not_known_is_missing(charted):
    _, _, _, chart = charted
    crashed, = points(chart, "interval")
    absent, = points(chart, "absent")
    assert crashed.state == "crashed" and "SIGSEGV" in crashed.message and crashed.accuracy is None
    assert absent.state == "missing" and "renderer-of-tomorrow" in absent.message
    assert [what for _, what, _ in chart.faults] == ["interval"]


def test_the_error_of_samples_falls(charted):
    growth, = charted[3].growths
    one, sixteen = growth.lines[0].points
    assert 0 < sixteen.second < 0.5 * one.second
    assert sixteen.rays > 10 * one.rays
    assert "16 times the samples" in growth.finding


def test_what_is_finished_is_not_measured_again(charted, nobody):
    folder, options, study, chart = charted
    again = measure.run([BALL], [study], options, SWEPT[:2] + SWEPT[3:])
    assert again.subjects[0].series == [s for s in chart.subjects[0].series if s.id != "interval"]
    assert again.growths == chart.growths
    other = measure.run([BALL], [], options, [CHOSEN["interval"]])  # a crash is not kept
    assert other.subjects[0].series[0].points[0].state == "crashed"
    assert all(file.with_suffix(".json").exists() for file in (folder / results.FOLDER).iterdir())


def test_the_document_survives_writing(charted, tmp_path):
    chart = charted[3]
    results.keep(chart, tmp_path)
    assert results.read(tmp_path) == chart


def test_a_scene_without_truth_costs_that_scene_alone(tmp_path, nobody):
    chart = measure.run([BALL], [], measure.Options(tmp_path, limit=60.0), [CHOSEN["exact"]])
    subject, = chart.subjects
    assert subject.state == "crashed" and "nobody may be asked" in subject.message and subject.series == []
    assert chart.faults


def test_every_study_makes_its_scenes():
    for full in (False, True):
        for study in studies(full):
            scenes = [study.scene(x) for x in study.values]
            assert len({s.hash for s in scenes}) == (1 if study.x_is_threads else len(scenes)), study.id
    samples = next(s for s in studies(False) if s.id == "samples")
    assert samples.reference().tracing.samples == REFERENCE_SAMPLES
    assert [samples.scene(x).tracing.samples ** 2 for x in samples.values] == [1, 4, 9, 16, 64, 256]


def test_subjects_by_default_and_all_of_them():
    few, all_of_them = chosen([], False, (32, 24)), chosen([], True, (32, 24))
    assert len(all_of_them) >= 20 and {c.scene.name for c in few} < {c.scene.name for c in all_of_them}
    assert {c.scene.tracing.samples for c in all_of_them} == {1}
    with pytest.raises(InputError, match="nowhere"):
        chosen(["nowhere"], False, (32, 24))


@pytest.mark.parametrize("arguments, told", [
    (["chart", "nowhere"], "nowhere"), (["chart", "--growth", "weeds"], "weeds"),
    (["chart", "--turns", "0"], "--turns"), (["chart", "--limit", "nan"], "--limit"),
    (["chart", "--size", "1x1"], "--size")])
def test_bad_input_is_one_sentence(arguments, told, capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert exit_code(*arguments) == 2
    said = capsys.readouterr().err.strip()
    assert told in said and "\n" not in said
    assert not list(tmp_path.iterdir())
