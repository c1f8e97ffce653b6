"""The pool: every task is answered, a fault costs its own, an interruption ends all at once and leaves nobody behind."""

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from test_misbehaving import alive, wait_until_gone
from workers import child, interruptible

from raytruth.comparisons.execution import pool
from raytruth.comparisons.execution.pool import Pool, Silent, Task, complete
from raytruth.comparisons.execution.store import Store, UnwritableError
from raytruth.comparisons.progress import Cases

DOES = """
do = arguments["do"]
if do == "kill":
    os.kill(os.getpid(), signal.SIGKILL)
if do == "hang":
    time.sleep(600)
if do == "garbage":
    print("garbage")
if do == "full":
    print(json.dumps({"state": "unwritable", "message": "results: cannot be written"}), flush=True)
    continue
if do == "wait":
    open(arguments["here"], "w").close()
    while not os.path.exists(arguments["there"]):
        time.sleep(0.01)
print(json.dumps({"state": "ok", "facts": {"process": os.getpid()}}))
"""


@pytest.fixture(autouse=True)
def workers(monkeypatch):
    monkeypatch.setattr(pool, "COMMAND", child(DOES))


def task(key, do="answer", process="", limit=60.0, **arguments):
    return Task(key, key, "nobody:asks", {"do": do, **arguments}, limit, process)


def answers(made, tasks):
    return {t.key: answer for t, answer in made.run(tasks)}


def test_a_fault_costs_its_own_task():
    tasks = [task("a"), task("killed", "kill"), task("b"), task("hanging", "hang", limit=0.5), task("c"),
             task("garbled", "garbage"), task("d")]
    with Pool(2) as made:
        found = answers(made, tasks)
    assert {key: answer["state"] for key, answer in found.items()} == {
        "a": "ok", "killed": "crashed", "b": "ok", "hanging": "timeout", "c": "ok", "garbled": "malformed", "d": "ok"}
    assert "SIGKILL" in found["killed"]["message"]


def test_as_many_tasks_as_jobs_are_made_at_the_same_time(tmp_path):
    """Each waits for a file that the other makes."""
    here, there = str(tmp_path / "here"), str(tmp_path / "there")
    with Pool(2) as made:
        found = answers(made, [task("a", "wait", here=here, there=there), task("b", "wait", here=there, there=here)])
    assert [answer["state"] for answer in found.values()] == ["ok", "ok"]


def test_processes_of_a_name_are_shared_and_end_when_nobody_waits_for_them():
    with Pool(1) as made:
        told, seen = {}, []
        for t, answer in made.run([task("a", process="x"), task("b", process="x"), task("c", process="y")]):
            told[t.key] = answer["facts"]["process"]
            seen.append([p for p in told.values() if alive(p)])
        assert told["a"] == told["b"] != told["c"]
        assert seen[0] == [told["a"]] and told["a"] not in seen[-1]


def test_lasting_processes_are_found_again_one_of_a_name():
    with Pool(2, lasting=True) as made:
        first = answers(made, [task("a", process="x"), task("b", process="x"), task("c", process="y")])
        again = made.ask(task("d", process="x"))
        assert first["a"]["facts"] == first["b"]["facts"] == again["facts"] != first["c"]["facts"]
    assert wait_until_gone([answer["facts"]["process"] for answer in first.values()])


def test_a_full_disk_ends_the_suite_with_its_sentence():
    with Pool(2) as made, pytest.raises(UnwritableError, match="results: cannot be written"):
        answers(made, [task("a", "full"), *(task(f"t{k}") for k in range(20))])


def test_leaving_early_ends_what_is_under_way():
    with Pool(2) as made:
        run = made.run([task("a"), task("hanging", "hang"), task("b")])
        next(run)
        busy = [worker._process.pid for worker, _, _ in made._busy.values() if worker._process]
    assert wait_until_gone(busy)


def test_what_is_made_is_kept_and_only_what_is_missing_is_made(tmp_path):
    kept, asked = Store(tmp_path, "kind"), []
    settle = lambda t, answer: asked.append(t.key) or {"state": answer["state"], "key": t.key}
    with Pool(2) as made:
        first = complete([task("a"), task("k", "kill"), task("a")], kept, made, json.loads, settle)
        again = complete([task("a"), task("k")], kept, made, json.loads, settle)
    assert sorted(asked) == ["a", "k", "k"]  # the failure is tried again
    assert first["a"] == again["a"] and [first["k"]["state"], again["k"]["state"]] == ["crashed", "ok"]


# --- progress --------------------------------------------------------------------------------------------------------
def test_a_line_for_every_case_that_has_ended_where_no_terminal_watches(capsys):
    with Cases() as progress, Pool(1, progress) as made:
        answers(made, [task("a"), task("b", "kill")])
        answers(made, [task("c")])
    told = capsys.readouterr().err.splitlines()
    assert [line.split(",")[0] for line in told] == ["a: ok", "b: crashed", "c: ok"]
    assert told[1].endswith("(2 of 2)") and told[2].endswith("(3 of 3)")


def test_what_a_worker_tells_on_its_way_is_passed_on(monkeypatch):
    """Three lines of progress, the last in one piece with the answer."""
    monkeypatch.setattr(pool, "COMMAND", child("""
        for k in (1, 2):
            print(json.dumps({"share": k / 4, "label": f"part {k}"}), flush=True)
        print(json.dumps({"share": 0.75, "label": "part 3"}) + "\\n" + json.dumps({"state": "ok"}), flush=True)
        """))
    told = []

    class Told(Silent):
        def begin(self, label, share=0.0):
            told.append((label, share))

    with Pool(1, Told()) as made:
        assert made.ask(task("a"))["state"] == "ok"
    assert told == [("a", 0.0), ("a: part 1", 0.25), ("a: part 2", 0.5), ("a: part 3", 0.75)]


# --- interruption ----------------------------------------------------------------------------------------------------
SUITES = {
    "compare": "from raytruth.comparisons import suite\nsuite.compare([SCENE], suite.Options(folder, with_studies=False))",
    "transport": "from raytruth.comparisons.transport import cases, measure\nmeasure.run(cases.find([]), folder)",
    "stability": "from raytruth.comparisons.stability import cases, measure\nmeasure.run(cases.find([]), folder)",
    "attribute": "from raytruth.comparisons.attribution.measure import wrong_on_purpose\nwrong_on_purpose(folder)",
    "chart": "from raytruth.comparisons.charting import cases, measure\nmeasure.run(cases.chosen([], False, (32, 24)), [], measure.Options(folder))",
    "plan": "from raytruth.comparisons.planning import measure\nlist(measure.run([SCENE], 1e-3, folder))",
}


def suite(name: str, folder: Path, **how) -> subprocess.Popen:
    """A suite whose every worker notes its id and hangs."""
    hanging = (sys.executable, "-c", f"""
import os, time
from raytruth.comparisons.execution import worker
def answer(request):
    with open({str(folder / 'note')!r}, "a") as note:
        note.write(f"{{os.getpid()}}\\n")
    time.sleep(600)
worker.answer = answer
worker.main()
""")
    program = (f"import sys; sys.path.insert(0, {str(Path(__file__).parent)!r})\nfrom pathlib import Path\n"
               f"from test_misbehaving import SCENE\nfrom raytruth.comparisons.execution import pool\npool.COMMAND = {hanging!r}\n"
               f"folder = Path({str(folder)!r})\nprint('here', flush=True)\n{SUITES[name]}")
    return subprocess.Popen([sys.executable, "-c", program], stderr=subprocess.PIPE, stdout=subprocess.DEVNULL, **how)


def noted(folder: Path) -> list[int]:
    """The ids of the workers, when there are some."""
    patience = time.monotonic() + 60
    while not ((folder / "note").exists() and (folder / "note").read_text()) and time.monotonic() < patience:
        time.sleep(0.02)
    return [int(line) for line in (folder / "note").read_text().split()]


@pytest.mark.parametrize("name", SUITES)
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGKILL, signal.SIGTERM])
def test_every_suite_that_is_interrupted_takes_its_workers_along(tmp_path, name, number):
    process = suite(name, tmp_path, preexec_fn=interruptible)
    assert noted(tmp_path)
    process.send_signal(number)
    said = process.communicate(timeout=60)[1]
    assert process.returncode and (number != signal.SIGINT or b"KeyboardInterrupt" in said)
    assert wait_until_gone(noted(tmp_path))


def test_where_an_interruption_is_ignored_work_goes_on(tmp_path):
    """As under nohup or in the background of a shell: SIGINT reaches nobody, the suite answers as it would."""
    ignored = lambda: signal.signal(signal.SIGINT, signal.SIG_IGN)
    process = suite("compare", tmp_path, preexec_fn=ignored)
    workers = noted(tmp_path)
    process.send_signal(signal.SIGINT)
    for worker in workers:  # all of them gone: the suite must notice that, and start others for the tasks that wait
        os.kill(worker, signal.SIGKILL)
    patience = time.monotonic() + 60
    while set(noted(tmp_path)) <= set(workers) and time.monotonic() < patience:
        time.sleep(0.02)
    assert process.poll() is None and set(noted(tmp_path)) > set(workers)
    process.terminate()
    process.communicate(timeout=60)
    assert wait_until_gone(noted(tmp_path))
