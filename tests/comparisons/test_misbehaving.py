"""Real renderers that crash, hang, or write garbage or nothing: each costs its own case, by name; the suite ends."""

import json
import os
import resource
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from misbehaving import WAYS
from workers import MISBEHAVING, interruptible

from raytruth.cli import main
from raytruth.comparisons import renderers
from raytruth.comparisons.execution import pool
from raytruth.comparisons.execution.pool import Pool
from raytruth.comparisons.execution.process import Worker
from raytruth.comparisons.runs import Request, RunStore
from raytruth.reference_tracer.scene.load import parse_scene

SCENE = parse_scene(json.dumps({
    "name": "ball", "camera": {"width": 24, "height": 16},
    "objects": [{"surface": {"type": "sphere", "center": [0, 0, 3], "r": 1}}],
    "lights": [{"position": [2, 2, 0]}]}).encode())
SOON = 10.0  # seconds: enough to start a worker on a machine that does other things, too


@pytest.fixture
def registered(monkeypatch):
    for way in WAYS:
        monkeypatch.setitem(renderers.RENDERERS, way, renderers.Renderer(way, f"the renderer with {way}", "misbehaving",
                                                                         {"way": way}))


def alive(process: int) -> bool:
    """Whether a process runs; one that ended and was not waited for does not."""
    try:
        return Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except FileNotFoundError:
        return False


def wait_until_gone(processes) -> bool:
    patience = time.monotonic() + 60
    while any(map(alive, processes)) and time.monotonic() < patience:
        time.sleep(0.02)
    return not any(map(alive, processes))


def test_every_fault_is_named_and_nothing_is_left_behind(registered, tmp_path, monkeypatch):
    monkeypatch.setattr(pool, "COMMAND", MISBEHAVING)
    store, found, children = RunStore(tmp_path), {}, []
    with Pool(1, lasting=True) as made:  # one after the other in the same worker: a fault must not touch the next case
        monkeypatch.setattr(Request, "process", "all of them")
        for way in WAYS:
            note = tmp_path / f"{way}.txt"
            settings = {"note": str(note)} if "child" in way or "disk" in way else {}
            limit = 60 if WAYS[way][0] != "timeout" else SOON if "child" in way else 1
            run = store.make(Request(SCENE, way, settings), made, limit)
            found[way] = run
            if "child" in way:
                children += map(int, note.read_text().split())
        assert store.make(Request(SCENE, "exact"), made, 60).state == "ok"
    for way, (state, word) in WAYS.items():
        assert found[way].state == state and word in found[way].message, (way, found[way])
        assert len(found[way].message) <= 600 and found[way].planes is None
    assert len(children) == 4 and wait_until_gone(children)
    assert {file.suffix for file in (tmp_path / "runs").iterdir()} == {".npz", ".json"}  # those of the sound run
    assert len(list((tmp_path / "runs").iterdir())) == 2


def test_the_suite_ends_and_its_exit_code_says_so(registered, tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(pool, "COMMAND", MISBEHAVING)
    scene = tmp_path / "ball.json"
    scene.write_text(SCENE.model_dump_json(by_alias=True, exclude={"schema_"}))
    common = ["compare", str(scene), "--results", str(tmp_path / "results"), "--no-studies", "--limit", "100"]
    assert main([*common, "--renderers", "embree,segfault,nan"]) == 1
    told = capsys.readouterr().out
    assert "the renderer with segfault crashed: the renderer's process was killed by SIGSEGV" in told
    assert "the renderer with nan malformed: left a picture without one finite colour" in told
    assert "agrees        ball--embree" in told
    assert main([*common, "--renderers", "embree"]) == 0


def test_an_interrupted_suite_leaves_at_once_and_takes_its_renderers_along(tmp_path):
    note = tmp_path / "note"
    program = f"""
import sys
sys.path.insert(0, {str(Path(__file__).parent)!r})
from misbehaving import WAYS
from test_misbehaving import SCENE
from workers import MISBEHAVING
from pathlib import Path
from raytruth.comparisons import renderers, suite
from raytruth.comparisons.execution import pool
renderers.RENDERERS["hang with a child"] = renderers.Renderer(
    "hang with a child", "", "misbehaving", {{"way": "hang with a child"}})
pool.COMMAND = MISBEHAVING
suite.compare([SCENE], suite.Options(Path({str(tmp_path)!r}), renderers=("hang with a child",), with_studies=False))
"""
    process = subprocess.Popen([sys.executable, "-c", program], stderr=subprocess.PIPE, env={**os.environ, "NOTE": str(note)},
                               preexec_fn=interruptible)
    patience = time.monotonic() + 30
    while not (note.exists() and len(note.read_text().split()) == 2) and time.monotonic() < patience:
        time.sleep(0.05)
    start = time.monotonic()
    process.send_signal(signal.SIGINT)
    assert b"KeyboardInterrupt" in process.communicate(timeout=30)[1] and time.monotonic() - start < 10
    assert note.exists() and wait_until_gone([int(line) for line in note.read_text().split()])


def test_a_suite_that_is_killed_takes_its_renderers_along(tmp_path):
    # a worker whose parent is gone has nobody to answer to, even while a renderer never returns
    program = "import sys, subprocess, time; p = subprocess.Popen([sys.executable, '-m', 'raytruth.comparisons.execution.worker'], " \
              "stdin=subprocess.PIPE, process_group=0); print(p.pid, p.stdin.fileno(), flush=True); time.sleep(60)"
    parent = subprocess.Popen([sys.executable, "-c", program], stdout=subprocess.PIPE)
    worker, pipe = map(int, parent.stdout.readline().split())
    open_end = os.open(f"/proc/{parent.pid}/fd/{pipe}", os.O_WRONLY)  # its input must not tell it that it is alone
    time.sleep(0.5)
    assert alive(worker)
    parent.kill()
    parent.wait()
    parent.stdout.close()
    assert wait_until_gone([worker])
    os.close(open_end)


def test_a_worker_that_begins_after_its_suite_was_killed_does_nothing(tmp_path):
    program = """
import json, os, subprocess, sys
worker = subprocess.Popen([sys.executable, "-m", "raytruth.comparisons.execution.worker"], stdin=subprocess.PIPE)
worker.stdin.write(json.dumps({"function": "time:sleep", "arguments": 600, "asker": os.getpid()}).encode() + b"\\n")
worker.stdin.flush()
print(worker.pid, flush=True)
os.kill(os.getpid(), 9)
"""
    parent = subprocess.run([sys.executable, "-c", program], stdout=subprocess.PIPE)
    assert wait_until_gone([int(parent.stdout)])


def test_what_a_worker_says_is_kept_within_bounds():
    program = "import sys\nfor line in sys.stdin:\n    [sys.stderr.write('y' * 65536) for _ in range(3000)]\n    print('?', flush=True)"
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    with Worker([sys.executable, "-c", program]) as worker:
        assert worker.ask({}, 60)["state"] == "malformed"  # 190 MB said, all read, 4 kB of it kept
        assert len(worker._said) <= 4096
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before < 50_000  # kB


def test_a_worker_that_does_not_read_times_out():
    # a request larger than a pipe holds: whoever writes it must not wait for ever
    with Worker([sys.executable, "-c", "import time; time.sleep(60)"]) as worker:
        start = time.monotonic()
        assert worker.ask({"scene": "x" * 1_000_000}, 1)["state"] == "timeout"
        assert time.monotonic() - start < 10


def test_a_second_answer_is_not_taken_for_the_next_request():
    program = "import sys, time\nfor k, line in enumerate(sys.stdin):\n" \
              "    print('{\"state\": \"ok\", \"message\": \"%d\"}' % k, flush=True); time.sleep(0.2)\n" \
              "    k or print('{\"state\": \"ok\", \"message\": \"late\"}', flush=True)"
    with Worker([sys.executable, "-c", program]) as worker:
        assert worker.ask({}, 20)["message"] == "0"
        time.sleep(0.5)
        assert worker.ask({}, 20)["message"] == "0"  # of a new process


@pytest.mark.parametrize("facts", ["{\"first\": \"soon\"}", "{\"list\": [1]}", "[1]", "\"fast\""])
def test_facts_that_are_none_cost_their_own_case(tmp_path, monkeypatch, facts):
    program = f"""
import json, sys
from raytruth.comparisons.execution.worker import answer
for line in sys.stdin:
    print(json.dumps({{**answer(json.loads(line)), "facts": {facts}}}), flush=True)"""
    monkeypatch.setattr(pool, "COMMAND", (sys.executable, "-c", program))
    with Pool(1) as made:
        assert RunStore(tmp_path).make(Request(SCENE, "exact"), made, 60).state == "malformed"
