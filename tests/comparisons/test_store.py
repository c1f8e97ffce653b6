"""The store: what is whole is found, what is not is made again, a failure is never kept, a bad place is one sentence."""

import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from raytruth.cli import main
from raytruth.comparisons import runs, suite
from raytruth.comparisons.execution import code, store
from raytruth.comparisons.execution.code import closure
from raytruth.comparisons.execution.pool import Silent
from raytruth.comparisons.execution.store import Store, UnwritableError, atomically
from raytruth.comparisons.results import Run, Timing
from raytruth.comparisons.runs import Request
from raytruth.reference_tracer.scene.load import parse_scene

BALL = json.dumps({
    "name": "ball", "camera": {"width": 24, "height": 16},
    "objects": [{"surface": {"type": "sphere", "center": [0, 0, 3], "r": 1}}],
    "lights": [{"position": [2, 2, 0]}]})
SCENE = parse_scene(BALL.encode())


def kept(folder) -> Store:
    made = Store(folder, "kind")
    store.save(made.file("k"), plane=np.arange(5000.0))
    assert made.keep("k", {"state": "ok", "number": 3.25, "gap": float("nan")}, arrays=True)
    return made


# --- what is kept ----------------------------------------------------------------------------------------------------
def test_a_record_and_its_arrays_come_back(tmp_path):
    made = kept(tmp_path)
    assert made.find("k", json.loads)["number"] == 3.25 and (made.arrays("k")["plane"] == np.arange(5000.0)).all()
    assert made.find("other", json.loads) is None and made.arrays("other") is None
    assert sorted(file.name for file in made.folder.iterdir()) == ["k.json", "k.npz"]  # no parts of files


@pytest.mark.parametrize("name", ["k.json", "k.npz"])
@pytest.mark.parametrize("damage", [
    lambda b: b[:-1], lambda b: b[:len(b) // 2], lambda b: b"", lambda b: b + b"x", lambda b: b"[" * 100_000,
    lambda b: b[:-20] + bytes([b[-20] ^ 1]) + b[-19:], lambda b: bytes([b[0] ^ 4]) + b[1:], lambda b: b.replace(b"3", b"4")],
    ids=["a byte short", "half", "empty", "a byte more", "nested", "a bit near the end", "the first bit", "another digit"])
def test_whatever_is_altered_is_not_found(tmp_path, name, damage):
    made = kept(tmp_path)
    file, before = made.folder / name, (made.folder / name).read_bytes()
    file.write_bytes(damage(before))
    if file.read_bytes() != before:
        assert made.find("k", json.loads) is None and made.arrays("k") is None


def test_a_lost_file_is_not_found(tmp_path):
    made = kept(tmp_path)
    made.file("k").unlink()
    assert made.find("k", json.loads) is None


@pytest.mark.parametrize("state", ["crashed", "timeout", "malformed", "missing", "refused"])
def test_a_failure_is_not_kept(tmp_path, state):
    made, run = Store(tmp_path, "runs"), Run(key="k", scene="s", renderer="r", title="", state=state, command="", timing=Timing())
    assert not made.keep("k", run) and made.find("k", Run.model_validate_json) is None


# --- the place -------------------------------------------------------------------------------------------------------
def test_an_interrupted_write_leaves_what_was_there_and_nothing_else(tmp_path):
    file = tmp_path / "file"
    file.write_text("before")
    with pytest.raises(ZeroDivisionError), atomically(file) as part:
        part.write_text("half")
        1 / 0
    assert file.read_text() == "before" and list(tmp_path.iterdir()) == [file]


def test_a_writer_that_is_killed_leaves_what_was_there_and_its_rest_goes_with_the_next(tmp_path):
    made = kept(tmp_path)
    program = ("import os, signal, sys\nfrom pathlib import Path\nfrom raytruth.comparisons.execution.store import atomically\n"
               "with atomically(Path(sys.argv[1])) as part:\n    part.write_text('half'); os.kill(os.getpid(), signal.SIGKILL)")
    assert subprocess.run([sys.executable, "-c", program, str(made.file("k"))]).returncode == -9
    assert made.arrays("k") is not None and len(list(made.folder.iterdir())) == 3
    made.forget("k")
    assert not list(made.folder.iterdir())


def test_a_full_disk_is_one_sentence(tmp_path):
    with pytest.raises(UnwritableError, match="file: cannot be written .No space left on device.; make room") as told:  # noqa: SIM117
        with atomically(tmp_path / "file") as part, open("/dev/full", "w") as full:  # every write there finds no room
            part.write_text("")
            full.write("x" * 100_000)
    assert "\n" not in str(told.value) and not list(tmp_path.iterdir())


def blocked(folder: Path, where: str) -> None:
    """Puts something in the place of a folder or a file."""
    path = folder / where
    if path.suffix == ".json":
        path.mkdir(parents=True)
    else:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text("here first")


@pytest.mark.parametrize("arguments, where", [
    (["compare", "ball.json", "--renderers", "paper", "--no-studies"], place)
    for place in (".", "runs", "measured", "results.json", "matrix.json")] + [
    (["transport", "one-over-pi", "-o", "results"], place) for place in (".", "transport", "transport.json")] + [
    (["stability", "--family", "horizon", "--rays", "50", "-o", "results"], place)
    for place in (".", "stability", "stability.json")] + [
    (["plan", "ball.json", "--results", "results"], place) for place in (".", "plans")] + [
    (["chart", "--growth", "samples", "-o", "results"], place) for place in (".", "chart")] + [
    (["attribute", "--wrong-on-purpose"], place) for place in (".", "attributions")])
def test_a_blocked_folder_is_one_sentence(tmp_path, monkeypatch, capsys, arguments, where):
    monkeypatch.chdir(tmp_path)
    Path("ball.json").write_text(BALL)
    blocked(Path("results"), where)
    assert main(arguments) == 2
    told = [line for line in capsys.readouterr().err.splitlines() if line.startswith("raytruth:")]  # progress may stand there too
    assert len(told) == 1 and told[0].startswith("raytruth: results") and "choose another" in told[0], told


def test_a_folder_that_may_not_be_written_is_one_sentence(tmp_path, monkeypatch):
    monkeypatch.setattr(os, "access", lambda *_: False)  # what a file system mounted to be read says; root may all else
    with pytest.raises(UnwritableError, match="cannot be written; choose another folder"):
        Store(tmp_path, "runs")


# --- whole suites ----------------------------------------------------------------------------------------------------
class Ended(Silent):
    def __init__(self):
        self.labels = []

    def end(self, label, seconds, state):
        self.labels.append(label)


@pytest.mark.parametrize("damage", [lambda b: b[:len(b) // 2], lambda b: b[:200] + bytes([b[200] ^ 8]) + b[201:]],
                         ids=["truncated", "a flipped bit"])
def test_a_damaged_picture_is_made_again_and_nothing_else(tmp_path, damage):
    ended = Ended()
    options = suite.Options(tmp_path, renderers=("paper",), with_studies=False, progress=ended)
    before = suite.compare([SCENE], options)
    file = tmp_path / before.run(before.comparisons[0].test).planes
    file.write_bytes(damage(file.read_bytes()))
    ended.labels.clear()
    after = suite.compare([SCENE], options)
    assert ended.labels == ["paper: ball"]
    assert [c.verdict for c in after.comparisons] == [c.verdict for c in before.comparisons] and np.load(file)["color"].any()


# --- keys ------------------------------------------------------------------------------------------------------------
def test_a_renderer_s_key_holds_its_own_code_and_no_other_s():
    ours, mitsuba, povray = (closure(f"raytruth.comparisons.renderers.{name}") for name in ("reference", "mitsuba", "povray"))
    assert "raytruth.converters.mitsuba.crossings" in mitsuba[0] and "raytruth.reference_tracer.tracer.world" in ours[0]
    assert not any(name.startswith("raytruth.converters.mitsuba") for name in povray[0] | ours[0])
    assert "raytruth.comparisons.renderers.povray_process" in povray[0] - mitsuba[0]
    assert "mitsuba" in mitsuba[1] and not {"mitsuba", "trimesh"} & (povray[1] | ours[1])
    # who is compared, how many at a time, and what is made of it changes no picture
    assert not {"raytruth.comparisons.suite", "raytruth.comparisons.execution.pool", "raytruth.comparisons.renderers"} & mitsuba[0]


@pytest.mark.parametrize("module, changes", [
    ("raytruth.converters.povray.text", {"povray"}), ("raytruth.converters.mitsuba.crossings", {"mitsuba-mesh"}),
    ("raytruth.reference_tracer.first_hit.descartes", {"exact", "povray", "mitsuba-mesh"}), ("raytruth.comparisons.suite", set())])
def test_a_change_of_source_changes_the_keys_of_those_who_reach_it(tmp_path, monkeypatch, module, changes):
    """Every renderer takes the reference's types from modules that reach its methods; nobody reaches the suite."""
    keys = lambda: {name: Request(SCENE, name).key for name in ("exact", "mitsuba-mesh", "povray")}
    before, file = keys(), code._file
    other = tmp_path / "other.py"
    other.write_bytes(file(module).read_bytes() + b"\n# changed\n")
    monkeypatch.setattr(code, "_file", lambda name: other if name == module else file(name))
    code.code.cache_clear()
    try:
        assert {name for name, key in keys().items() if key != before[name]} == changes
    finally:
        code.code.cache_clear()


def test_another_llvm_and_another_pov_ray_are_other_keys(monkeypatch):
    key = lambda name: Request(SCENE, name).key
    before = {name: key(name) for name in ("exact", "povray")}
    monkeypatch.setattr(code, "_llvm", lambda: "libLLVM.so.16 1")
    code.code.cache_clear()
    try:
        assert key("exact") != before["exact"]
    finally:
        monkeypatch.undo()
        code.code.cache_clear()
    monkeypatch.setattr("raytruth.comparisons.renderers.program", lambda name: "POV-Ray 3.8")
    assert key("povray") != before["povray"] and key("exact") == before["exact"]


def test_scenes_that_differ_in_name_share_a_run_and_keep_their_names(tmp_path):
    made = runs.RunStore(tmp_path)
    request = Request(SCENE, "exact")
    made.keep(request.key, Run(key=request.key, scene="ball", renderer="exact", title="", state="ok", command=request.command))
    other = Request(SCENE.model_copy(update={"name": "bowl"}), "exact")
    assert made.finished(other).scene == "bowl" and "bowl.npz" in made.finished(other).command


def test_a_program_tells_its_version_wherever_it_says_it(tmp_path, monkeypatch):
    """POV-Ray's first line may be a complaint about a file of settings."""
    program = tmp_path / "povray"
    program.write_text("#!/bin/sh\necho 'povray: cannot open the user configuration file /home/someone/.povray/3.7/povray.conf' >&2\n"
                       "echo 'POV-Ray 3.7.0.8.unofficial' >&2\n")
    program.chmod(0o755)
    monkeypatch.setenv("PATH", str(tmp_path), prepend=os.pathsep)
    code.program.cache_clear()
    assert code.program("povray") == "POV-Ray 3.7.0.8.unofficial"
    code.program.cache_clear()
