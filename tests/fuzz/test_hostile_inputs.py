"""The first hostile inputs of `make fuzz`, and that the judge of them notices what it is there to notice."""

import fuzz
import fuzz_inputs
import pytest

INPUTS = 300


def test_hostile_inputs_end_in_one_sentence_or_a_picture():
    """Each wrong input is told with the command that brings it back."""
    assert fuzz.run(range(INPUTS), seed=0, jobs=2) == []


def test_an_input_is_the_same_whenever_it_is_made():
    assert fuzz_inputs.make(0, 77) == fuzz_inputs.make(0, 77) != fuzz_inputs.make(1, 77)
    assert {fuzz_inputs.make(0, k).kind for k in range(INPUTS)} == {"torn", "mutated", "formulas", "extreme", "options"}


def outcome(code, err="", out="", memory=0):
    return fuzz.Outcome(code, out, err, memory, 0.1)


SENTENCE = "raytruth: scene.json: must be a scene"


@pytest.mark.parametrize("given, must_fail, wrong", [
    (outcome(0), False, None), (outcome(1), False, None), (outcome(2, SENTENCE), True, None),
    (outcome(0, "raytruth: a: 9 camera rays will take 9 s\na: 3% after 0:05"), False, None),
    (outcome(0), True, "bad input and exit code 0"), (outcome(2, ""), True, "0 sentences"),
    (outcome(2, SENTENCE + "\n" + SENTENCE), True, "2 sentences"), (outcome(2, "ValueError: must be a scene"), True, "not a clear"),
    (outcome(2, SENTENCE + "\x1b[31m"), True, "not a clear"), (outcome(2, SENTENCE + "x" * 9999), True, "not a clear"),
    (outcome(2, SENTENCE, "half a table"), True, "on stdout"), (outcome("traceback", "KeyError: 'x'"), False, "KeyError: 'x'"),
    (outcome(1, "Traceback (most recent call last):"), False, "traceback"), (outcome("crash"), False, "crash"),
    (outcome("silent"), False, "silent"), (outcome("stuck"), False, "stuck"), (outcome(-11), False, "exit code -11"),
    (outcome(0, memory=3 << 30), False, "took 3.0 GiB"), (outcome("told"), True, "works on bad input")])
def test_the_judge(given, must_fail, wrong):
    found = fuzz.verdict(fuzz_inputs.Input(0, "", ["render"], must_fail=must_fail), given)
    assert found is None if wrong is None else wrong in found


@pytest.fixture
def worker(tmp_path, monkeypatch):
    """A worker whose command line is the program given to `obeys`."""
    (tmp_path / "raytruth").mkdir()
    (tmp_path / "raytruth" / "__init__.py").touch()

    def obeys(program: str):
        (tmp_path / "raytruth" / "cli.py").write_text(program)
        monkeypatch.setattr(fuzz, "ROOT", tmp_path)
        return made

    made = fuzz.Worker(tmp_path)
    made.obeys = obeys
    yield made
    made.close()


@pytest.mark.parametrize("body, code", [
    ("raise KeyError('seconds')", "traceback"), ("import os; os.abort()", "crash"), ("return 3", 3), ("raise SystemExit(2)", 2),
    ("while True: pass", "silent"), ("x = bytearray(1 << 28); x[::4096] = b'1' * (1 << 16)\n    while True: pass", "memory"),
    ("import sys, time; print('raytruth: a will take 9 years', '0% after 0:05', sep=chr(10), file=sys.stderr, flush=True)\n"
     "    time.sleep(1000)", "told"),
    ("import time; time.sleep(1000)", "stuck")])
def test_the_watch_over_a_worker(worker, monkeypatch, body, code):
    """It sees tracebacks, crashes, silence and memory, and goes on with the next input."""
    monkeypatch.setattr(fuzz, "SILENCE", 0.2 if code == "silent" else 60.0)
    monkeypatch.setattr(fuzz, "STUCK", 3.0)
    monkeypatch.setattr(fuzz, "MEMORY", 1 << 27)
    watched = worker.obeys(f"def main(arguments):\n    {body}\n")
    assert watched.run(fuzz_inputs.Input(0, "", ["render"])).code == code
    watched = worker.obeys("def main(arguments):\n    return 0\n")
    if watched.process is None or (isinstance(code, str) and code not in ("traceback",)):
        assert watched.run(fuzz_inputs.Input(0, "", ["render"])).code == 0
