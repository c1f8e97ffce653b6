"""The engine on Dask: a scheduler and workers in processes of their own, which are killed, hang and start anew."""

import contextlib
import json
import os
import signal
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

from raytruth.cli import main
from raytruth.comparisons.execution import cluster as engines
from raytruth.comparisons.execution.cluster import Cluster
from raytruth.comparisons.execution.pool import Task, complete
from raytruth.comparisons.execution.store import Store, load
from raytruth.comparisons.random_scenes import suite
from raytruth.reference_tracer.errors import InputError

pytest.importorskip("distributed", reason="Dask is not installed")
TIMES = ("created", "seconds", "timing", "cpu", "peak_mib", "others")  # what differs from run to run


class Processes:
    """A scheduler and its workers."""

    def __init__(self, folder: Path, port: int = 0):
        self.folder, self.file, self.all = folder, folder / "scheduler.json", []
        paths = [str(Path(__file__).parent), os.environ.get("PYTHONPATH", "")]
        self.environment = {**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, paths))}
        self.file.unlink(missing_ok=True)
        self.scheduler = self.start("scheduler", "--port", str(port), "--scheduler-file", str(self.file), "--no-show")
        while not self.file.exists() or not self.file.read_text():
            assert self.scheduler.poll() is None
            time.sleep(0.05)
        self.address = json.loads(self.file.read_text())["address"]

    def workers(self, count: int):
        for _ in range(count):
            self.start("worker", self.address, "--nthreads", "1", "--local-directory", str(self.folder))
        return self

    def start(self, what: str, *options: str):
        process = subprocess.Popen([sys.executable, "-m", "dask", what, *options, "--no-dashboard", "--host", "127.0.0.1"],
                                   env=self.environment, cwd=self.folder, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
                                   process_group=0)
        self.all.append(process)
        return process

    def kill(self):
        for process in self.all:
            with_group(process)
        self.all.clear()


def with_group(process):
    with contextlib.suppress(ProcessLookupError):
        os.killpg(process.pid, signal.SIGKILL)
    process.wait()


@pytest.fixture(scope="module")
def processes(tmp_path_factory):
    started = Processes(tmp_path_factory.mktemp("dask")).workers(2)
    yield started
    started.kill()


def task(key, does="well", limit=60.0, process="", **arguments):
    return Task(key, key, f"cluster_cases:{does}", {"number": 7, **arguments}, limit, process)


def test_a_fault_costs_its_own_case(processes, tmp_path):
    tasks = [*(task(f"well {k}", number=k) for k in range(6)), task("dead", "dies"), task("hanging", "hangs", limit=1.0),
             task("bereft", "ends_its_worker", marks=str(tmp_path / "twice"), times=2),
             task("deadly", "ends_its_worker", marks=str(tmp_path / "always"), times=1000), task("unknown", "nowhere")]
    with Cluster(processes.address) as made:
        found = {t.key: answer for t, answer in made.run(tasks)}
    assert [found[f"well {k}"]["facts"]["number"] for k in range(6)] == [k**2 for k in range(6)]
    assert {key: found[key]["state"] for key in ("dead", "hanging", "bereft", "deadly", "unknown")} == {
        "dead": "crashed", "hanging": "timeout", "bereft": "ok", "deadly": "crashed", "unknown": "crashed"}
    assert "SIGKILL" in found["dead"]["message"] and "workers were lost" in found["deadly"]["message"]


def test_a_scheduler_that_starts_anew_is_given_what_has_no_answer_yet(tmp_path):
    first = Processes(tmp_path).workers(1)
    port = int(first.address.rpartition(":")[2])
    gate, begun = tmp_path / "gate", tmp_path / "begun"
    tasks = [task("before"), task("during", "waits", gate=str(gate), begun=str(begun)), task("after", number=3)]
    second = None
    with ThreadPoolExecutor(1) as pool, Cluster(first.address) as made:
        answers = pool.submit(lambda: {t.key: a["state"] for t, a in made.run(tasks)})
        try:
            while not begun.exists():
                time.sleep(0.05)
            first.kill()
            second = Processes(tmp_path, port).workers(1)
            gate.touch()
            assert answers.result(timeout=120) == {"before": "ok", "during": "ok", "after": "ok"}
        finally:
            gate.touch()
            for started in filter(None, (first, second)):
                started.kill()


def test_two_at_once_on_one_store_find_the_same(processes, tmp_path):
    marks = tmp_path / "marks"
    tasks = [task(f"{k:024x}", "counted", number=k, marks=str(marks)) for k in range(8)]

    def run(_):
        with Cluster(processes.address) as made:
            return complete(tasks, Store(tmp_path, "kept"), made, json.loads, lambda _, answer: {
                "state": answer["state"], "number": answer["facts"]["number"]})

    with ThreadPoolExecutor(2) as pool:
        one, other = pool.map(run, range(2))
    assert one == other == {f"{k:024x}": {"state": "ok", "number": k**2} for k in range(8)}
    made = len(marks.read_text().splitlines())
    assert run(0) == one and len(marks.read_text().splitlines()) == made  # all is kept


def test_random_scenes_are_judged_as_they_are_here(processes):
    told = lambda **where: sorted((vars(answer) for answer in suite.run(4, 40, 2, **where)), key=lambda answer: answer["seed"])
    assert told(cluster=processes.address) == told()


def test_a_comparison_is_the_one_that_is_made_here(processes, tmp_path):
    asked = ["compare", "figure-05-sphere", "--renderers", "paper", "--largest", "40", "--no-studies"]
    documents, pictures = [], []
    for name, where in (("here", []), ("there", ["--cluster", processes.address])):
        assert main([*asked, "-o", str(tmp_path / name), *where]) == 0
        documents.append(timeless(json.loads((tmp_path / name / "results.json").read_text())))
        pictures.append({f"{path.stem} {plane}": array.tobytes() for path in (tmp_path / name / "runs").glob("*.npz")
                         for plane, array in load(path).items() if plane != "metadata"})  # which tells the time
    assert documents[0] == documents[1] and pictures[0] == pictures[1] and len(pictures[0]) >= 2 * 5


def timeless(value):
    """A document without TIMES."""
    if isinstance(value, dict):
        return {name: timeless(v) for name, v in value.items() if name not in TIMES}
    return [timeless(v) for v in value] if isinstance(value, list) else value


def test_what_does_not_fit_is_one_sentence(processes, monkeypatch, capsys):
    monkeypatch.setattr(engines, "source_hash", lambda: "another")
    with Cluster(processes.address) as made, pytest.raises(InputError, match="a worker runs another raytruth"):
        list(made.run([task("any")]))
    monkeypatch.undo()
    for address, word in (("tcp://127.0.0.1:9", "no Dask scheduler answers"), ("nonsense://x", "no Dask scheduler answers")):
        assert main(["stability", "--cluster", address, "--family", "grazing"]) == 2
        error = capsys.readouterr().err
        assert word in error and error.count("\n") == 1


def test_certificates_are_those_that_are_made_here(processes, capsys):
    arguments = ["certify", "figure-05-sphere", "figure-07-torus", "--size", "32x24", "--sample", "60", "--paths", "2", "--json"]
    made = []
    for where in ([], ["--cluster", processes.address]):
        assert main([*arguments, *where]) == 0
        made.append(sorted((c | {"seconds": 0} for c in json.loads(capsys.readouterr().out)), key=lambda c: c["scene"]))
    assert made[0] == made[1] and len(made[0]) == 2


def test_a_certificate_that_a_cluster_cannot_make_is_told(processes, capsys):
    assert main(["certify", "figure-05-sphere", "--size", "16x16", "--method", "guess", "--cluster", processes.address]) == 1
    assert "figure-05-sphere: no certificate" in capsys.readouterr().err


@pytest.mark.parametrize("address", ["nonsense", "tcp://127.0.0.1:9", "gopher://127.0.0.1:9"])
def test_an_address_where_nobody_answers_is_one_sentence(address):
    """In a process of its own, whose end frees whatever Dask has begun."""
    done = subprocess.run([sys.executable, "-m", "raytruth", "certify", "figure-05-sphere", "--cluster", address],
                          capture_output=True, text=True)
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr == f"raytruth: --cluster {address}: no Dask scheduler answers there; start one with 'dask scheduler'\n"
