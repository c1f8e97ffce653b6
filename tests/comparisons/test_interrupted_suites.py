"""Whole suites that are killed, interrupted, find their results damaged or no room for them: what they leave equals what an
uninterrupted run leaves, or one sentence says why not."""

import json
import os
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from test_misbehaving import wait_until_gone

from raytruth.cli import main
from raytruth.comparisons import times
from raytruth.comparisons.execution.store import Store
from raytruth.comparisons.verdicts import conditioning
from raytruth.reference_tracer.scene.load import parse_scene
from raytruth.reference_tracer.tracer.image_files import load_npz

# the literal method's step is longer than the ball is thick at its rim: its comparison is expected, and has an attribution
BALL = json.dumps({
    "name": "ball", "camera": {"width": 16, "height": 12}, "tracing": {"step_size": 2.5, "max_distance": 10, "max_depth": 1},
    "objects": [{"surface": {"type": "sphere", "center": [0, 0, 3], "r": 1}}], "lights": [{"position": [2, 2, 0]}]})
KINDS = ("runs/*.json", "runs/*.npz", "measured/*.json", "attributions/*.json", "histories/*.json", "results.json",
         "matrix.json", "times.json")
TIMES = ("created", "seconds", "machine", "timing", "cpu")


def compare(folder: Path) -> list[str]:
    return ["compare", str(folder.parent / "ball.json"), "--renderers", "paper", "--no-studies", "--results", str(folder)]


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "ball.json").write_text(BALL)
    return tmp_path / "results"


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """What an uninterrupted run leaves."""
    place = tmp_path_factory.mktemp("whole")
    (place / "ball.json").write_text(BALL)
    assert main(compare(place / "results")) == 0
    return place / "results"


def left(folder: Path) -> dict:
    """All that is in `folder`, without times: what a suite took has a file of its own."""
    def timeless(found):
        if isinstance(found, dict):
            return {name: timeless(value) for name, value in found.items() if name not in TIMES}
        return [timeless(value) for value in found] if isinstance(found, list) else found

    found = {}
    for file in (file for file in folder.rglob("*") if file.is_file() and file != folder / times.FILE):
        if file.suffix == ".npz":
            content = {name: plane.tobytes() for name, plane in load_npz(file)[0].items() if isinstance(plane, np.ndarray)}
        else:  # what is kept has a line with checksums before its record
            content = timeless(json.loads(file.read_text().split("\n", 1)[1] if file.parent != folder else file.read_text()))
        found[str(file.relative_to(folder))] = content
    return found


def sentence(capsys) -> str:
    """What is told when a command refuses: a line of it, and no traceback."""
    said = capsys.readouterr().err
    told, = [line for line in said.splitlines() if line.startswith("raytruth:")]
    assert "Traceback" not in said
    return told


def heals(folder: Path, whole: Path) -> None:
    assert main(compare(folder)) == 0
    assert left(folder) == left(whole)


def test_all_kinds_of_files_are_there_and_another_picture_is_not_the_same(whole, tmp_path):
    known = [set(whole.glob(kind)) for kind in KINDS]
    assert all(known) and set().union(*known) == {file for file in whole.rglob("*") if file.is_file()}
    other = tmp_path / "results"
    shutil.copytree(whole, other)
    assert left(other) == left(whole)
    one, two = sorted(other.glob("runs/*.npz"))
    two.write_bytes(one.read_bytes())
    assert left(other) != left(whole)


@pytest.mark.parametrize("how, after", [(signal.SIGKILL, "runs/*.npz"), (signal.SIGKILL, "measured/*.json"),
                                        (signal.SIGINT, KINDS[0])])
def test_a_suite_that_is_ended_in_the_middle_goes_on_where_it_stopped(folder, whole, how, after):
    hearing = lambda: signal.signal(signal.SIGINT, signal.default_int_handler)  # a test in the background inherits it ignored
    process = subprocess.Popen([sys.executable, "-m", "raytruth", *compare(folder)], stderr=subprocess.PIPE, text=True,
                               preexec_fn=hearing, cwd=Path(__file__).parents[2])
    patience = time.monotonic() + 60
    while not list(folder.glob(after)) and process.poll() is None and time.monotonic() < patience:
        time.sleep(0.005)
    threads = Path(f"/proc/{process.pid}/task").iterdir()
    children = [int(pid) for thread in threads for pid in (thread / "children").read_text().split()]
    process.send_signal(how)
    _, said = process.communicate(timeout=10)
    assert process.returncode == (-9 if how == signal.SIGKILL else 130) and "Traceback" not in said
    if how == signal.SIGINT:
        assert said.splitlines()[-1] == "raytruth: interrupted; finished runs are kept"
    assert wait_until_gone(children) and (children or after != KINDS[0])
    assert not (folder / "results.json").exists()
    finished = {file: file.stat().st_mtime_ns for file in folder.glob("*/*.json")}
    heals(folder, whole)
    assert all(file.stat().st_mtime_ns == written for file, written in finished.items())  # nothing was made twice


DAMAGES = {"truncated": lambda b: b[:len(b) // 2], "empty": lambda b: b"", "garbage": lambda b: np.random.default_rng(1).bytes(900)}


@pytest.mark.parametrize("shift", range(len(DAMAGES)))
def test_damaged_files_of_every_kind_are_made_again(folder, whole, shift):
    """Every kind with every damage; other kinds have others at the same time."""
    shutil.copytree(whole, folder)
    for number, kind in enumerate(KINDS):
        damage = list(DAMAGES.values())[(number + shift) % len(DAMAGES)]
        for file in folder.glob(kind):
            file.write_bytes(damage(file.read_bytes()))
    heals(folder, whole)


@pytest.mark.parametrize("damage", DAMAGES)
@pytest.mark.parametrize("suffix", ["json", "npz"])
def test_damaged_limits_are_made_again(tmp_path, damage, suffix, monkeypatch):
    kept, scene = Store(tmp_path, conditioning.FOLDER), parse_scene(BALL.encode())
    monkeypatch.setattr(conditioning, "response", lambda *a, made=conditioning.response, **b: made(*a, **b, probes=1))
    found = conditioning.limits(scene, conditioning.Accuracy(32), kept)
    file, = kept.folder.glob(f"*.{suffix}")
    file.write_bytes(DAMAGES[damage](file.read_bytes()))
    assert (conditioning.limits(scene, conditioning.Accuracy(32), kept).color == found.color).all()
    monkeypatch.setattr(conditioning, "response", None)  # and are whole again: measuring once more would fail
    assert (conditioning.limits(scene, conditioning.Accuracy(32), kept).color == found.color).all()


@pytest.mark.parametrize("kind", KINDS)
def test_a_folder_in_the_place_of_a_file_is_one_sentence(folder, whole, capsys, kind):
    shutil.copytree(whole, folder)
    file = sorted(folder.glob(kind))[0]
    file.unlink()
    (file / "here first").mkdir(parents=True)
    assert main(compare(folder)) == 2
    told = sentence(capsys)
    assert told.startswith(f"raytruth: {file}: cannot be written") and "choose another folder" in told


@pytest.fixture
def disk(folder):
    """A file system of its own in the place of the results; its size and rights change by the options that it is called with."""
    folder.mkdir()
    mount = lambda options: subprocess.run(["mount", "-t", "tmpfs", "-o", options, "tmpfs", folder], capture_output=True)
    if not shutil.which("mount") or mount("size=64k").returncode:
        pytest.skip("needs the right to mount a file system")
    try:
        yield lambda options: subprocess.run(["mount", "-o", f"remount,{options}", folder], check=True)
    finally:
        subprocess.run(["umount", "-l", folder], check=True)


def test_a_full_disk_is_one_sentence_and_with_room_again_it_goes_on(folder, whole, capsys, disk):
    disk(f"size={4 * os.sysconf('SC_PAGE_SIZE')}")
    assert main(compare(folder)) == 2
    assert "No space left on device" in (told := sentence(capsys)) and told.startswith(f"raytruth: {folder}"), told
    assert not list(folder.rglob("*.part"))
    disk("size=16m")
    heals(folder, whole)


def test_a_disk_that_can_only_be_read_is_one_sentence(folder, capsys, disk):
    disk("ro")
    assert main(compare(folder)) == 2
    assert sentence(capsys).startswith(f"raytruth: {folder}")
