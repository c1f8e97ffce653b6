"""raytruth certify: exit codes, text and JSON."""

import argparse
import json

import pytest
from certify_support import make_scene, thing

from raytruth.commands import certify as command
from raytruth.reference_tracer.errors import InputError


def _run(*words: str) -> int:
    parser = argparse.ArgumentParser()
    command.add_arguments(parser)
    return command.run(parser.parse_args([*words]))


@pytest.fixture
def scene_file(tmp_path):
    def write(**surface):
        path = tmp_path / "scene.json"
        scene = make_scene(thing(center=(0, 0, 3), name="thing", **surface), step_size=0.2)
        path.write_text(scene.model_dump_json(by_alias=True, exclude_none=True))
        return str(path)
    return write


def test_a_sound_scene_exits_with_0_and_is_told(scene_file, capsys):
    assert _run(scene_file(kind="sphere", r=1.0), "--sample", "40", "--paths", "2") == 0
    out = capsys.readouterr().out
    assert "24 x 18, method exact: holds" in out and "primary" in out and "40 rays decided exactly" in out


def test_a_failing_method_exits_with_1_and_says_where(scene_file, capsys):
    """The literal method steps over a ball thinner than its step."""
    path = scene_file(kind="ellipsoid", a=1.0, b=1.0, c=0.02)
    assert _run(path, "--method", "paper", "--sample", "40", "--paths", "0") == 1
    out = capsys.readouterr().out
    assert "DOES NOT HOLD" in out and "missed hit, primary rays, thing (object 0)" in out


def test_json_for_programs(scene_file, capsys):
    path = scene_file(kind="sphere", r=1.0)
    assert _run(path, "--sample", "40", "--paths", "2", "--size", "12x9", "--json") == 0
    document, = json.loads(capsys.readouterr().out)
    assert document["passed"] and (document["width"], document["height"]) == (12, 9)
    assert document["kinds"]["primary"]["rays"] == 108 and document["paths"]["paths"] == 2


@pytest.mark.parametrize("words, message", [
    (("--size", "0x9"), "--size"), (("--method", "guess"), "unknown method")])
def test_bad_input_is_one_clear_sentence(scene_file, words, message):
    with pytest.raises(InputError, match=message):
        _run(scene_file(kind="sphere", r=1.0), *words)
