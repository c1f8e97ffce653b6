"""The transport suite: judging Monte Carlo, child processes, kept cases, the document, the command, the page."""

import json
import textwrap

import numpy as np
import pytest
from workers import child, exit_code

from raytruth.cli import main
from raytruth.comparisons.execution import pool
from raytruth.comparisons.transport import cases, measure
from raytruth.comparisons.transport import document as results
from raytruth.converters.mitsuba.radiance import Radiance
from raytruth.reference_tracer.errors import InputError

CHOSEN = cases.find(["diffuse", "mirror-blend"])
GATES = [{"name": "color p99", "value": 1e-6, "limit": 2e-5, "holds": True, "means": "m"}]
METRICS = {"mean difference from the document": 0.1, "largest difference from the document": 0.2}


GOOD = f"""
np.savez(arguments["planes"], document=np.zeros((4, 6, 3)), mitsuba=np.zeros((4, 6, 3)), expected=np.zeros((4, 6, 3)),
         compared=np.ones((4, 6), bool))
print(json.dumps({{"state": "ok", "facts": {{"gates": {GATES!r}, "metrics": {METRICS!r}, "seconds": 0.5}}}}))
"""


# --- judging Monte Carlo ---------------------------------------------------------------------------------------------
def test_sidaks_limit():
    """One test at 1 %: 2.5758; 7500 tests share the level so that none of them exceeds it in 99 % of all cases."""
    assert measure.sidak_limit(1) == pytest.approx(2.575829, rel=1e-6)
    from math import erf, sqrt
    assert erf(measure.sidak_limit(7500) / sqrt(2)) ** 7500 == pytest.approx(0.99, rel=1e-9)


def made_of(draws):
    """(h, w, 3) means and variances from (h, w, 3, n) samples."""
    n = draws.shape[-1]
    return Radiance(draws.mean(-1), draws.var(-1) / (n - 1), n)


def largest(draws, expected):
    ones = np.ones(expected.shape[:2], bool)
    return float(np.abs(measure.scores(made_of(draws), expected, np.zeros(ones.shape), ones)).max())


@pytest.mark.parametrize("p", [0.5, 0.05, 0.005, 0.0005])
def test_faultless_coins_pass_however_rare_heads_are(p):
    random = np.random.default_rng(5)
    expected = np.full((24, 32, 3), p)
    expected[0, 0] = 1  # what heads are worth is seen somewhere in the picture
    for _ in range(4):
        draws = (random.random((24, 32, 3, 500)) < expected[..., None]).astype(float)
        assert largest(draws, expected) < measure.sidak_limit(expected.size)


@pytest.mark.parametrize("p", [0.5, 0.05])
def test_biased_coins_are_found(p):
    random = np.random.default_rng(6)
    expected = np.full((24, 32, 3), p)
    draws = (random.random((24, 32, 3, 4000)) < 1.4 * p).astype(float)
    assert largest(draws, expected) > measure.sidak_limit(expected.size)


def test_without_noise_one_percent_is_found():
    expected = np.full((4, 4, 3), 0.5)
    seen = Radiance(1.01 * expected, np.zeros_like(expected), 64)
    none = np.zeros((4, 4))
    assert np.abs(measure.scores(seen, expected, none, none > 0)).min() > 1000
    assert np.abs(measure.scores(seen, 1.01 * expected, none, none > 0)).max() == 0


def test_slopes():
    assert measure.slope({4: 1.0, 16: 0.5, 64: 0.25}) == pytest.approx(-0.5)
    assert measure.slope({4: 1.0, 16: 1.0, 64: 1.0}) == pytest.approx(0.0, abs=1e-12)


# --- child processes -------------------------------------------------------------------------------------------------
@pytest.fixture
def workers(monkeypatch):
    """Lets programs of these bodies stand where workers are."""
    return lambda body: monkeypatch.setattr(pool, "COMMAND", child(body))


def test_a_crash_costs_its_own_case_and_finished_ones_are_kept(tmp_path, workers):
    crash = 'if arguments["case"] == "diffuse":\n    os.abort()\n' + textwrap.dedent(GOOD)
    workers(crash)
    document = measure.run(CHOSEN, tmp_path, jobs=1)
    states = [(c.id, c.state, c.holds) for c in document.cases]
    assert states == [("diffuse", "crashed", False), ("mirror-blend", "ok", True)]
    assert "SIGABRT" in document.cases[0].reason and [c.id for c in document.failed] == ["diffuse"]
    # what is finished is not asked for again, what crashed is
    asked = tmp_path / "asked"
    workers(f"open({str(asked)!r}, 'a').write(arguments['case'])\n" + textwrap.dedent(GOOD))
    again = measure.run(CHOSEN, tmp_path, jobs=1)
    assert asked.read_text() == "diffuse" and not again.failed and again.cases[1] == document.cases[1]


@pytest.mark.parametrize("body, state", [
    ("time.sleep(60)", "timeout"), ("print('GARBAGE')", "malformed"),
    ('print(json.dumps({"state": "ok", "facts": {"gates": [{"name": 3}], "metrics": {}}}))', "malformed"),
    ('print(json.dumps({"state": "ok", "facts": {}}))', "malformed")])
def test_a_case_that_is_not_measured_does_not_hold(tmp_path, workers, body, state):
    workers(body)
    record, = measure.run(CHOSEN[:1], tmp_path, limit=0.8 if state == "timeout" else 20).cases
    assert record.state == state and not record.holds and record.planes is None


def test_a_broken_gate_is_told(tmp_path, workers):
    broken = GOOD.replace("1e-06", "0.5").replace("'holds': True", "'holds': False")
    workers(broken)
    document = measure.run(CHOSEN[:1], tmp_path)
    assert document.failed and "color p99 is 0.5" in document.cases[0].reason


def test_the_document_comes_back_and_is_not_written_twice(tmp_path, workers):
    workers(GOOD)
    document = measure.run(CHOSEN, tmp_path)
    results.keep(document, tmp_path)
    later = document.model_copy(update={"created": "later", "seconds": 9})
    assert results.read(tmp_path) == document == results.keep(later, tmp_path)
    (tmp_path / results.FILE).write_text('{"version": 7}')
    with pytest.raises(InputError, match="raytruth transport"):
        results.read(tmp_path)


# --- the command -----------------------------------------------------------------------------------------------------
def test_the_command_measures_a_case_and_says_so_in_one_line(tmp_path, capsys):
    assert main(["transport", "one-over-pi", "-o", str(tmp_path)]) == 0
    line, = capsys.readouterr().out.splitlines()
    assert line.startswith("finding") and "one-over-pi" in line
    assert results.read(tmp_path).cases[0].metrics["pixels compared"] == 320 * 240


def test_the_commands_exit_codes(tmp_path, capsys, workers):
    assert main(["transport", "caustics"]) == 2
    assert "unknown case 'caustics'; choose one of diffuse" in capsys.readouterr().err
    assert exit_code("transport", "--jobs", "0") == 2
    workers("os.abort()")
    assert main(["transport", "mirror", "-o", str(tmp_path), "--json"]) == 1
    assert json.loads(capsys.readouterr().out)["cases"][0]["state"] == "crashed"
