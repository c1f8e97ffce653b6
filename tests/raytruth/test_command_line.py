"""The command line as a stranger uses it: what it prints, its exit codes, and how it answers bad input."""

import json
import os
import subprocess
import sys

import pytest

from raytruth.cli import COMMANDS, main


def run(capsys, *arguments):
    try:
        code = main(list(map(str, arguments)))
    except SystemExit as stop:  # argparse
        code = stop.code
    out, err = capsys.readouterr()
    return code, out, err


@pytest.fixture
def ball(tmp_path):
    path = tmp_path / "ball.json"
    path.write_text(json.dumps({"name": "ball", "camera": {"width": 16, "height": 12},
                                "objects": [{"surface": {"type": "sphere", "center": [0, 0, 3], "r": 1}}],
                                "lights": [{"position": [2, 2, 0]}]}))
    return path


def test_help_teaches(capsys):
    code, out, _ = run(capsys, "--help")
    assert code == 0 and "first steps" in out and all(name in out for name in COMMANDS)
    for name in COMMANDS:
        code, out, _ = run(capsys, name, "--help")
        assert code == 0 and len(out) > 150


def test_scenes_lists_checks_and_shows(capsys, ball):
    code, out, _ = run(capsys, "scenes")
    assert code == 0 and "figure-05-sphere" in out
    code, out, _ = run(capsys, "scenes", ball, "--json")
    assert code == 0 and json.loads(out)[0]["surfaces"] == ["sphere"]
    code, out, _ = run(capsys, "scenes", "--show", "figure-07-torus")
    assert code == 0 and json.loads(out)["objects"][0]["surface"]["type"] == "torus"
    code, out, _ = run(capsys, "scenes", "--schema")
    assert code == 0 and json.loads(out)["$schema"].startswith("https://json-schema.org")


def test_a_shown_scene_is_a_scene_file(capsys, tmp_path):
    from reference_tracer.scene.library import scene
    from reference_tracer.scene.load import load_scene

    _, out, _ = run(capsys, "scenes", "--show", "figure-reflection")
    (tmp_path / "mine.json").write_text(out)
    assert load_scene(tmp_path / "mine.json").hash == scene("figure-reflection").hash


@pytest.mark.parametrize("suffix", ["png", "exr", "npz"])
def test_render_writes_a_picture(capsys, ball, tmp_path, suffix):
    code, out, err = run(capsys, "render", ball, "-o", tmp_path / f"out.{suffix}", "--json")
    told = json.loads(out)
    assert code == 0 and not err and (tmp_path / f"out.{suffix}").stat().st_size > 100
    assert told["pixels"]["undecided"] == 0 and told["pixels"]["hit"] + told["pixels"]["miss"] == 16 * 12


BAD = [
    (["scenes", "no-such-scene"], "no-such-scene: is neither a file nor a shipped scene"),
    (["render", "{ball}", "-o", "{dir}/out.gif"], "must end in one of .png, .exr, .npz"),
    (["render", "{ball}", "-o", "{dir}/missing/out.png"], "does not exist; make it first"),
    (["render", "{ball}", "-o", "{dir}/out.png", "--method", "magic"], "unknown method 'magic'; choose one of paper"),
    (["render", "{ball}", "-o", "{dir}/out.png", "--size", "99999x9"], "width: must be at most"),
    (["render", "{ball}", "-o", "{dir}/out.png", "--samples", "0"], "samples: must be at least 1"),
    (["render", "{ball}", "-o", "{dir}/out.png", "--step-size", "nan"], "step_size: must be a finite number"),
    (["render", "{ball}", "-o", "{dir}/out.png", "--threads", "0"], "threads must be between 1 and"),
    (["render", "{ball}", "-o", "{dir}/out.png", "--device", "cuda"], "no CUDA device was found"),
    (["render", "{ball}", "-o", "{dir}/out.png", "--with", "blender"], "unknown renderer 'blender'"),
    (["render", "{ball}", "-o", "{dir}/out.png", "--with", "mitsuba-mesh", "--set", "resolution"], "must be KEY=VALUE"),
    (["render", "{dir}/broken.json", "-o", "{dir}/out.png"], "broken.json: line 1, column 2: is not JSON"),
    (["compare", "{ball}", "--renderers", "blender", "--results", "{dir}/r"], "unknown renderer 'blender'"),
    (["compare", "{ball}", "{ball}", "--results", "{dir}/r"], "two scenes are named 'ball'"),
    (["compare", "{ball}", "--largest", "1", "--results", "{dir}/r"], "--largest: must be at least 8"),
    (["report", "--results", "{dir}/nothing"], "results.json: cannot be read"),
]


@pytest.mark.parametrize("arguments, sentence", BAD)
def test_bad_input_is_one_sentence_and_exit_code_2(capsys, ball, tmp_path, arguments, sentence):
    (tmp_path / "broken.json").write_text("{")
    before = sorted(tmp_path.rglob("*"))
    code, out, err = run(capsys, *(a.format(ball=ball, dir=tmp_path) for a in arguments))
    assert code == 2 and not out
    assert sentence in err and err.startswith("raytruth: ") and err.count("\n") == 1
    assert sorted(tmp_path.rglob("*")) == before, "bad input must leave nothing behind"


def test_a_setting_that_the_renderer_does_not_know_is_refused(capsys, ball, tmp_path):
    code, _, err = run(capsys, "render", ball, "-o", tmp_path / "out.png", "--with", "exact", "--set", "colour=red")
    assert code == 2 and "colour" in err and err.count("\n") == 1


def test_rendering_does_not_import_mitsuba(ball, tmp_path):
    program = ("import sys; from raytruth.cli import main; "
               f"code = main(['render', {str(ball)!r}, '-o', {str(tmp_path / 'out.png')!r}]); "
               "sys.exit(code or 'mitsuba' in sys.modules)")
    assert subprocess.run([sys.executable, "-c", program], capture_output=True).returncode == 0


def test_doctor_finds_what_the_tests_run_on(capsys):
    code, out, _ = run(capsys, "doctor", "--json")
    findings = {f["name"]: f for f in json.loads(out)}
    assert code == 0 and all(findings[name]["found"] for name in ("Python", "Dr.Jit", "LLVM", "Mitsuba"))


def test_doctor_survives_an_llvm_that_cannot_be_used(tmp_path):
    # the probe runs in a process of its own: a library that is none must end in a sentence, not in a crash
    bogus = tmp_path / "libLLVM.so"
    bogus.write_bytes(b"not a library")
    process = subprocess.run([sys.executable, "-m", "raytruth", "doctor"], capture_output=True, text=True,
                             env={**os.environ, "DRJIT_LIBLLVM_PATH": str(bogus)})
    assert process.returncode == 1 and "Traceback" not in process.stderr
    assert "MISSING LLVM" in process.stdout and "karellen-llvm-core" in process.stdout
