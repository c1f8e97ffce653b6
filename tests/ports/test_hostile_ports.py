"""A port is a stranger's program: whatever it does, the checker says what that was, in time, and nothing is left of it."""

import os
import sys
import tempfile
import time
from pathlib import Path
from xml.etree import ElementTree

import pytest

from raytruth.cli import main
from raytruth.comparisons.ports import check, document
from raytruth.comparisons.ports.cases import chosen
from raytruth.comparisons.ports.document import Check
from raytruth.comparisons.ports.session import Failure, Port, _processes
from raytruth.comparisons.ports.truth import Truths
from raytruth.comparisons.suites import head

PROGRAM = Path(__file__).with_name("hostile.py")
SECONDS = 3.0  # that an answer may take here
PATIENT = 30.0  # where the port needs its time to use more than it may
SLACK = 10.0  # seconds beyond it: starting Python on a busy machine, ending three hundred processes

BEFORE = [("silent", "timeout", "no answer within"), ("endless", "malformed", "longer than 64 KiB"),
          ("stderr only", "timeout", "no answer"), ("exit 137", "crashed", "ended with exit code 137"),
          ("garbage", "malformed", "is not JSON: <html>"), ("killed", "crashed", "killed by SIGKILL"),
          ("closes its output", "crashed", "closed its output"), ("nothing", "crashed", "exit code 0"),
          ("deep", "malformed", "is not JSON")]
AFTER = [("hang", "timeout", "no answer within"), ("endless answer", "malformed", "longer than 64 KiB"),
         ("10 GB", "malformed", "announces 10,737,418,240 bytes"), ("negative size", "malformed", "whole number"),
         ("size in words", "malformed", "whole number"), ("NaN", "non-finite", "not finite"),
         ("infinite", "non-finite", "not finite"), ("wrong shape", "malformed", "shape must be"),
         ("wrong dtype", "malformed", "dtype must be float64 or float32"), ("wrong seq", "malformed", '"seq" is 2'),
         ("no colour", "malformed", "1 to 4 arrays"), ("short", "crashed", "59 bytes short of an answer"),
         ("twice", "malformed", "bytes more than announced"), ("dies", "crashed", "exit code 137"),
         ("forks", "crashed", "processes"), ("forks and detaches", "crashed", "processes"),
         ("fills the disk", "crashed", "it wrote"), ("swells", "crashed", "of memory"),
         ("refuses", "skipped", "<script>alert(1)</script>?[31m"), ("one grey", "fail", "26 of 26 rays differ")]


@pytest.fixture(scope="module")
def truths(tmp_path_factory):
    return Truths(tmp_path_factory.mktemp("truths"))


@pytest.fixture
def nothing_left():
    """No process, and no folder."""
    folders = lambda: set(Path(tempfile.gettempdir()).glob("raytruth-checked-*"))
    mine = lambda: {pid for pid, (parent, _, _) in _processes().items() if parent == os.getpid()}
    before, running = folders(), mine()
    yield
    assert folders() <= before
    assert mine() <= running
    assert not [pid for pid in _processes() if b"hostile.py" in _line(pid) or b"sleep\x001009" in _line(pid)]


def _line(pid):
    try:
        return Path(f"/proc/{pid}/cmdline").read_bytes()
    except OSError:
        return b""


def port(name, **rest):
    return Port([sys.executable, str(PROGRAM), name], **rest)


@pytest.mark.parametrize("name, verdict, said", BEFORE)
def test_a_port_that_cannot_be_greeted(name, verdict, said, nothing_left):
    start = time.monotonic()
    with port(name) as process:
        found = process.greet(SECONDS)
    assert isinstance(found, Failure) and found.verdict == verdict and said in found.message
    assert found.message.isprintable() and time.monotonic() - start < SECONDS + SLACK


@pytest.mark.parametrize("name, verdict, said", AFTER)
def test_a_port_that_answers_wrongly(name, verdict, said, truths, nothing_left):
    case, = chosen(["algorithm:surfaces/plane"])
    truths.planes(case)
    seconds = SECONDS if verdict == "timeout" else PATIENT
    start = time.monotonic()
    with port(name, memory=1 << 28) as process:
        result, = check.check(process, process.greet(PATIENT), [case], truths, seconds)
    assert result.verdict == verdict and said in result.message, result
    assert result.message.isprintable() and time.monotonic() - start < seconds + SLACK


def test_an_answer_too_many_is_not_taken_for_the_next_one(truths, nothing_left):
    """It comes when the first has been read: with the second case at the latest it is found."""
    cases = chosen(["algorithm:surfaces/plane", "algorithm:surfaces/sphere"])[:2]
    with port("late") as process:
        _, second = check.check(process, process.greet(PATIENT), cases, truths, PATIENT)
    assert second.verdict == "malformed", second


def test_a_port_that_always_hangs_is_given_up(truths, nothing_left):
    cases = chosen(["algorithm:surfaces"])
    with port("hang") as process:
        results = check.check(process, process.greet(PATIENT), cases, truths, 0.5)
    assert [r.verdict for r in results] == ["timeout"] * 3 + ["skipped"] * (len(cases) - 3)
    assert "failed 3 times in a row" in results[-1].message


def test_nothing_a_port_says_becomes_markup(truths, capsys, tmp_path, nothing_left):
    out = tmp_path / "out.xml"
    code = main(["check-port", "-o", str(tmp_path), "--only", "algorithm:surfaces/plane", "--junit", str(out), "--badge",
                 str(tmp_path / "badge.json"), "--", sys.executable, str(PROGRAM), "one grey"])
    printed = capsys.readouterr().out
    assert code == 1 and "\x1b" not in printed
    suite = ElementTree.fromstring(out.read_bytes())  # is well-formed
    assert "<script>" in suite.get("name") and b"<script>" not in out.read_bytes()


def test_failures_that_are_known(truths, nothing_left):
    cases = chosen(["algorithm:surfaces/plane", "algorithm:surfaces/sphere"])
    with port("one grey") as process:
        declared = process.greet(PATIENT)
        first = check.check(process, declared, cases, truths, 10)
        again = check.check(process, declared, cases, truths, 10, known=frozenset(r.id for r in first))
    made = lambda results: Check(**head(time.monotonic()), command=["x"], port=declared, results=results)
    assert not made(first).holds and made(again).holds
    mended = [again[0].model_copy(update={"verdict": "pass"}), again[1]]
    assert not made(mended).holds and made(mended).mended == [cases[0].id]
    assert document.badge(made(first))["color"] == "red" and document.badge(made(again))["message"] == "0/2"


def test_a_list_of_known_failures_is_read_back(truths, tmp_path):
    case, = chosen(["algorithm:surfaces/plane"])
    with port("NaN") as process:
        declared = process.greet(PATIENT)
        results = check.check(process, declared, [case], truths, 10)
    document.write_known(Check(**head(time.monotonic()), command=["x"], port=declared, results=results), tmp_path / "k.json")
    assert document.read_known(tmp_path / "k.json") == {case.id}
