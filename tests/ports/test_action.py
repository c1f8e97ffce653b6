"""The GitHub action: its own steps, run as they stand."""

import json
import sys
from pathlib import Path

import pytest
import wrong_ports

from tools import action

PORT = f"{sys.executable} {wrong_ports.NUMPY_SOURCE}"


@pytest.fixture
def runner(tmp_path):
    """The runner's folder, as the step before leaves it: with raytruth installed, here this one."""
    (tmp_path / "temp" / "raytruth").mkdir(parents=True)
    (tmp_path / "temp" / "raytruth" / "bin").symlink_to(Path(sys.executable).parent)
    (tmp_path / "checkout").mkdir()
    return tmp_path / "temp", tmp_path / "checkout"


def checked(runner, **inputs):
    temp, folder = runner
    return action.run({name.replace("_", "-"): value for name, value in inputs.items()}, temp, slice(1, None), folder)


def test_a_port_is_checked_and_its_badge_named(runner):
    code, told = checked(runner, port=PORT, options="--only algorithm:surfaces/plane --only algorithm:surfaces/sphere")
    badge = json.loads((runner[1] / told["badge"]).read_text())
    assert code == 0 and badge["message"].startswith("2/2") and (runner[1] / "raytruth.xml").exists()


def test_a_wrong_port_fails_unless_its_failures_are_listed(runner, tmp_path):
    port = " ".join(wrong_ports.wrong_numpy("own colour in full", tmp_path))
    only = "--only algorithm:events/mixing"
    assert checked(runner, port=port, options=only)[0] == 1
    known = runner[1] / "known.json"
    known.write_text(json.dumps({"format": "raytruth known failures 1", "failing": ["algorithm:events/mixing"]}))
    assert checked(runner, port=port, options=only, known_failures="known.json")[0] == 0


def test_what_an_input_says_is_no_script(runner):
    code, _ = checked(runner, port='$(touch pwned) `touch pwned`; touch pwned "', options="")
    assert code != 0 and not (runner[1] / "pwned").exists()
