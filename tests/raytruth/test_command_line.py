"""The command line as a stranger uses it: what it prints, its exit codes, and how it answers bad input."""

import json
import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

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


def test_a_shell_takes_the_completion_and_completes_an_option(capsys, tmp_path):
    code, script, _ = run(capsys, "--print-completion", "bash")
    (tmp_path / "completion").write_text(script)
    asked = (f"source {tmp_path / 'completion'}; complete -p raytruth; "
             "COMP_WORDS=(raytruth attribute --wro); COMP_CWORD=2; _shtab_raytruth; echo ${COMPREPLY[@]}")
    told = subprocess.run(["bash", "-c", asked], capture_output=True, text=True)
    assert code == 0 and "_shtab_raytruth raytruth" in told.stdout and "--wrong-on-purpose" in told.stdout


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
    from raytruth.reference_tracer.scene.library import scene
    from raytruth.reference_tracer.scene.load import load_scene

    _, out, _ = run(capsys, "scenes", "--show", "figure-reflection")
    (tmp_path / "mine.json").write_text(out)
    assert load_scene(tmp_path / "mine.json").hash == scene("figure-reflection").hash


@pytest.mark.parametrize("suffix", ["png", "exr", "npz"])
def test_render_writes_a_picture(capsys, ball, tmp_path, suffix):
    code, out, err = run(capsys, "render", ball, "-o", tmp_path / f"out.{suffix}", "--json")
    told = json.loads(out)
    assert code == 0 and "Traceback" not in err and (tmp_path / f"out.{suffix}").stat().st_size > 100
    assert told["pixels"]["undecided"] == 0 and told["pixels"]["hit"] + told["pixels"]["miss"] == 16 * 12


BAD = [
    (["scenes", "no-such-scene"], "no-such-scene: is neither a file nor a shipped scene; 'raytruth scenes' lists those"),
    (["render", "figure-5-sphere", "-o", "x.png"], "did you mean figure-05-sphere?"),
    (["scenes", "heart"], "did you mean figure-09-heart?"),
    (["certify", "--cluster", "tcp://127.0.0.1:9"], "--cluster tcp://127.0.0.1:9: no Dask scheduler answers there"),
    (["attribute", "figure-05-sphere", "--with", "paper", "--cluster", "tcp://127.0.0.1:9"], "--cluster: spreads --wrong-on-purpose"),
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
    (["render", "{ball}", "-o", "{dir}/out.png", "--set", "resolution=16"], "--set resolution=16: is a setting of the renderer"),
    (["render", "{ball}", "-o", "{dir}/out.png", "--with", "embree", "--method", "paper"], "--method: is an option of raytruth's"),
    (["render", "{ball}", "-o", "{dir}/out.png", "--with", "embree", "--precision", "32"], "--precision: is an option of"),
    (["render", "{ball}", "-o", "{dir}/out.png", "--with", "embree", "--device", "llvm"], "--device: is an option of"),
    (["render", "{ball}", "-o", "{dir}/out.png", "--with", "embree", "--threads", "1"], "--threads: is an option of"),
    (["render", "{ball}", "-o", "{dir}/out.png", "--with", "embree", "--set", "resolution=abc"], "resolution=abc: must be a whole"),
    (["render", "{ball}", "-o", "{dir}/out.png", "--with", "embree", "--set", "resolution=NaN"], "resolution=NaN: must be a whole"),
    (["render", "{ball}", "-o", "{dir}/out.png", "--with", "mitsuba-mesh", "--set", "error=nan"], "error=nan: must be a finite"),
    (["render", "{ball}", "-o", "{dir}/out.png", "--with", "embree", "--set", "resolution=" + "[" * 9999], "must be a whole number"),
    (["render", "{ball}", "-o", "{dir}/out.png", "--with", "embree", "--set", "resolution=9", "--set", "resolution=9"], "second time"),
    (["render", "{ball}", "-o", "{dir}/out.png", "--size", "16384x4096"], "GiB of memory, more than 2.0 GiB; take more by --memory"),
    (["render", "{ball}", "-o", "{dir}/out.png", "--memory", "0.2"], "more than 0.2 GiB; take more by --memory"),
    (["sensitivity", "{ball}", "--size", "0x0"], "--size: width: must be at least 1; found 0"),
    (["sensitivity", "{ball}", "--verify", "-3"], "--verify: must be at least 0; found '-3'"),
    (["sensitivity", "{ball}", "--size", "16384x4096"], "GiB of memory"),
    (["certify", "{ball}", "--size", "0x5"], "--size: width: must be at least 1"),
    (["certify", "{ball}", "--sample", "-1"], "--sample: must be at least 0"),
    (["transport", "--limit", "nan", "-o", "{dir}/r"], "--limit: must be a number; found 'nan'"),
    (["transport", "-o", "{ball}/below"], "ball.json is not a folder"),
    (["compare", "{ball}", "--results", "{ball}"], "ball.json is not a folder"),
    (["stability", "--rays", "9" * 5000], "--rays: must be at most 999999999"),
    (["plan", "{ball}", "--tolerance", "1e400"], "--tolerance: must be at most 1"),
    (["chart", "{ball}", "--size", "4x4"], "--size: sides must be at least 8"),
    (["attribute", "{ball}", "--with", "paper", "--jobs", "0"], "--jobs: must be at least 1"),
    (["scenes", "{dir}/misspelt.json"], "objects[0].surface.radius: is not a key this place knows; did you mean r?"),
    (["scenes", "{dir}/pipe.json"], "pipe.json: is not a regular file"), (["scenes", "/dev/zero"], "is not a regular file"),
    (["export", "{ball}", "-o", "{dir}/out.usd"], "must end in one of .ply, .obj, .stl, .glb, .xml, .pov, .txt"),
    (["export", "{ball}", "-o", "{dir}/missing/out.ply"], "does not exist; make it first"),
    (["export", "{ball}", "-o", "{dir}/out.ply", "--object", "cube"], "has no object 'cube'; give a number from 0 to"),
    (["export", "{ball}", "-o", "{dir}/out.pov", "--object", "0"], "holds a whole scene; one object goes to .ply"),
    (["export", "{ball}", "-o", "{dir}/out.ply", "--cells", "3"], "--cells: must be at least 4"),
    (["stability", "--family=--"], "--family=--: is an option without a value"),
    (["export", "{ball}", "-o", "{dir}/out.ply", "--object=--"], "--object=--: is an option without a value"),
    (["scenes", "a\0b.json"], "holds the character NUL"), (["scenes", "--colour"], "unrecognized arguments: --colour"),
    (["render", "{ball}"], "the following arguments are required: -o/--output"), (["rendre"], "invalid choice: 'rendre'"),
]


@pytest.mark.parametrize("arguments, sentence", BAD)
def test_bad_input_is_one_sentence_and_exit_code_2(capsys, ball, tmp_path, arguments, sentence):
    (tmp_path / "broken.json").write_text("{")
    (tmp_path / "misspelt.json").write_text('{"objects": [{"surface": {"type": "sphere", "radius": 1}}]}')
    os.mkfifo(tmp_path / "pipe.json")  # that nobody writes to: reading it would wait for ever
    before = sorted(tmp_path.rglob("*"))
    code, out, err = run(capsys, *(a.replace("{ball}", str(ball)).replace("{dir}", str(tmp_path)) for a in arguments))
    assert code == 2 and not out
    assert sentence in err and len(err) < 1000 and err.startswith("raytruth: ") and err.count("\n") == 1
    assert sorted(tmp_path.rglob("*")) == before, "bad input must leave nothing behind"


def test_a_setting_that_the_renderer_does_not_know_is_refused(capsys, ball, tmp_path):
    code, _, err = run(capsys, "render", ball, "-o", tmp_path / "out.png", "--with", "exact", "--set", "colour=red")
    assert code == 2 and "colour" in err and err.count("\n") == 1


@pytest.mark.parametrize("as_json", [[], ["--json"]])
@pytest.mark.parametrize("renderer, settings", [("embree", ["resolution=16"]), ("paper", ["step_size=0.2", "repeat=False"]),
                                                ("mitsuba-mesh", ["resolution=16", "error=None", "refined=True"])])
def test_another_renderer_draws_with_its_settings(capsys, ball, tmp_path, renderer, settings, as_json):
    """Settings as printed commands write them: Python's True, False and None among them."""
    options = [word for setting in settings for word in ("--set", setting)]
    code, out, err = run(capsys, "render", ball, "-o", tmp_path / "out.npz", "--with", renderer, *options, *as_json)
    assert code == 0 and "Traceback" not in err and (tmp_path / "out.npz").exists()
    if as_json:
        told = json.loads(out)
        assert told["seconds"] > 0 and told.get("resolution", 16) == 16 and told.get("refined", True) is True
    else:
        assert out.startswith(f"{tmp_path / 'out.npz'}: 16 x 12, ") and " s; " in out


def test_printed_commands_of_runs_are_understood(capsys, tmp_path):
    """What a results page prints is parsed to the same settings."""
    from raytruth.comparisons import renderers
    from raytruth.comparisons.runs import Request
    from raytruth.reference_tracer.scene.library import find

    for name, settings in (("embree", {"resolution": 32}), ("mitsuba-mesh", {"error": 0.25, "refined": True}),
                           ("paper", {"step_size": 0.05})):
        words = Request(find("effect-shadow"), name, settings).command.split()
        typed = dict(words[k + 1].split("=", 1) for k, word in enumerate(words) if word == "--set")
        assert renderers.parsed(words[words.index("--with") + 1], typed) == settings


def glass(depth: int, many: int = 9):
    ball = lambda k: {"surface": {"type": "sphere", "center": [k % 3 - 1, k // 3 - 1, 4], "r": 0.5},
                      "material": {"reflection": 0.5, "transparency": 0.5, "refractive_index": 1.5}}
    return {"name": "glass", "camera": {"width": 640, "height": 480}, "objects": [ball(k) for k in range(many)],
            "background": [1, 1, 1], "tracing": {"max_depth": depth}}


def started(scene, tmp_path):
    """A render in a process of its own, once it has told its estimate; and that estimate."""
    (tmp_path / "scene.json").write_text(json.dumps(scene))
    # a test runner in the background lets its children ignore Ctrl-C
    program = "import signal, sys; signal.signal(signal.SIGINT, signal.default_int_handler)\n" \
              "from raytruth.cli import main; sys.exit(main(sys.argv[1:]))"
    process = subprocess.Popen([sys.executable, "-c", program, "render", tmp_path / "scene.json", "-o", tmp_path / "out.png"],
                               stderr=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
    for line in process.stderr:
        if "rays" in line and " will take " in line:
            return process, line
    raise AssertionError("it ended without an estimate")


def test_a_cost_out_of_proportion_is_told_before_and_ctrl_c_ends_it_in_one_sentence(tmp_path):
    """2^65 - 1 rays a pixel at most, as the materials and the depth have it; progress follows the estimate."""
    process, estimate = started(glass(depth=64), tmp_path)
    try:
        assert estimate.startswith("raytruth: glass: 307,200 camera rays and ") and " will take " in estimate
        assert f"(at most {307200 * (2**65 - 2):.1e})" in estimate
        assert re.search(r"glass: \d+% after \d+:\d\d", process.stderr.readline())
        process.send_signal(signal.SIGINT)
        out, err = process.communicate(timeout=120)
    finally:
        process.kill()
        process.wait()
    assert process.returncode == 130 and not out
    assert [line for line in err.splitlines() if "% after" not in line] == ["raytruth: interrupted"]
    assert not (tmp_path / "out.png").exists()


def test_rendering_does_not_import_mitsuba(ball, tmp_path):
    program = ("import sys; from raytruth.cli import main; "
               f"code = main(['render', {str(ball)!r}, '-o', {str(tmp_path / 'out.png')!r}]); "
               "sys.exit(code or 'mitsuba' in sys.modules)")
    assert subprocess.run([sys.executable, "-c", program], capture_output=True).returncode == 0


def test_doctor_finds_what_the_tests_run_on_wherever_it_stands(capsys, monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)  # in a checkout, `python -c` finds modules that are not installed
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


def program(folder, name: str, text: str):
    path = folder / name
    path.write_text(f"#!/bin/sh\n{text}\n")
    path.chmod(0o755)
    return path


@pytest.mark.parametrize("name, says, found, detail", [
    ("povray", "echo 'povray: cannot open /home/someone/.povray/3.7/povray.conf' >&2; echo 'POV-Ray 3.7.0.10.unofficial'", True,
     "3.7.0.10.unofficial"),
    ("chromium", "echo '[: 25276510208: unexpected operator' >&2; echo 'Chromium 156.0.8078.108 built on Debian GNU/Linux 12'",
     True, "156.0.8078.108"),
    ("chromium", "echo 3.14", False, "does not say that it is Chromium"), ("povray", "exit 3", False, "does not say that it is")])
def test_doctor_reads_the_version_and_nothing_else(tmp_path, monkeypatch, name, says, found, detail):
    from raytruth.commands import doctor

    path = program(tmp_path, name, says)
    monkeypatch.setenv("PATH", f"{tmp_path}:{os.environ['PATH']}")
    title = {"povray": "POV-Ray", "chromium": "Chromium"}[name]
    finding = doctor._program(title, (name,), "apt-get", "a test")
    assert finding.found is found and (finding.detail == f"{detail}, {path}" if found else detail in finding.detail)


def test_doctor_leaves_nothing_of_a_program_that_hangs(tmp_path, monkeypatch):
    from raytruth.commands import doctor

    program(tmp_path, "povray", f"sleep 1000 & echo $! > {tmp_path}/child; wait")
    monkeypatch.setenv("PATH", f"{tmp_path}:{os.environ['PATH']}")
    monkeypatch.setattr(doctor, "SECONDS", 1.5)
    finding = doctor._program("POV-Ray", ("povray",), "apt-get", "a test")
    assert not finding.found and "gave no answer within" in finding.detail
    child = (tmp_path / "child").read_text().strip()
    deadline = time.monotonic() + 30  # whoever inherits the child may reap it a moment later
    while os.path.exists(f"/proc/{child}") and "Z" not in Path(f"/proc/{child}/stat").read_text().rpartition(")")[2].split()[0]:
        assert time.monotonic() < deadline, "a child of the program lives on"
        time.sleep(0.05)


@pytest.mark.parametrize("wrapped", [False, True])
def test_an_interruption_is_one_whoever_raises_it(wrapped, monkeypatch, capsys):
    """While Dr.Jit records, Ctrl-C surfaces as an error of its own, caused by it."""
    from raytruth.commands import scenes

    def interrupted(arguments):
        try:
            raise KeyboardInterrupt
        except KeyboardInterrupt as error:
            if wrapped:
                raise RuntimeError("a loop could not be recorded") from error
            raise

    monkeypatch.setattr(scenes, "run", interrupted)
    assert main(["scenes"]) == 130 and capsys.readouterr().err == "raytruth: interrupted\n"
    monkeypatch.setattr(scenes, "run", lambda arguments: 1 / 0)
    with pytest.raises(ZeroDivisionError):
        main(["scenes"])


@pytest.mark.parametrize("command", [["render", "-o", "{dir}/a.npz"], ["certify", "--paths=0", "--sample=0"], ["sensitivity"]])
def test_what_kernels_take_to_compile_is_told_before(command, tmp_path, monkeypatch, capsys):
    """For any size of picture, by each command that compiles; what would surely be short is not told."""
    from raytruth import cli, compile_time

    arguments = [command[0], "figure-05-sphere", "--size=4x3", *(a.replace("{dir}", str(tmp_path)) for a in command[1:])]
    cli.main(arguments)
    assert "to compile" not in capsys.readouterr().err
    monkeypatch.setattr(compile_time, "UNTOLD", 0.1)
    cli.main(arguments)
    assert re.search(r"^raytruth: figure-05-sphere: .* operations will take .* to compile", capsys.readouterr().err)


@pytest.mark.parametrize("command", [["render", "-o", "/proc/a.npz"], ["export", "-o", "/proc/a.ply"], ["sensitivity", "-o", "/proc/a.npz"],
                                     ["plan", "-o", "/proc/a.json"], ["plan", "--results", "/proc/a"]])
def test_a_place_that_takes_no_files_is_refused_before_the_work(command, capsys, monkeypatch):
    """The permissions of /proc let root write."""
    from raytruth.reference_tracer.tracer.render import Renderer

    monkeypatch.setattr(Renderer, "__init__", lambda *_, **__: pytest.fail("the work has begun"))
    from raytruth import cli

    assert cli.main([command[0], "figure-05-sphere", *command[1:]]) == 2
    assert "/proc" in capsys.readouterr().err


def test_a_certificate_that_does_not_fit_memory_is_refused(capsys):
    from raytruth import cli

    assert cli.main(["certify", "figure-05-sphere", "--size=4096x4096"]) == 2
    assert "of memory" in capsys.readouterr().err


@pytest.mark.parametrize("command", ["certify", "sensitivity"])
def test_no_shipped_scene_is_too_large_for_a_command_that_is_allowed_nothing(command):
    """`raytruth certify` alone takes every shipped scene, each at its own size."""
    from importlib import import_module

    from raytruth import memory
    from raytruth.reference_tracer.scene import library
    from raytruth.reference_tracer.tracer import estimate
    from raytruth.reference_tracer.tracer.film import PLANES

    beside = import_module(f"raytruth.commands.{command}").BESIDE
    for name in (*library.names(), *library.effects()):
        assert estimate.memory(library.find(name), PLANES, beside) <= memory.UNASKED * memory.GIB, name


def test_a_scene_as_published(capsys, tmp_path):
    """The figure's form by the option and by the name's ending; one that does not tell of its figure is refused."""
    from raytruth.reference_tracer.scene import library

    for words in (["figure-05-sphere", "--as-published"], ["figure-05-sphere@published"]):
        code, out, _ = run(capsys, "render", *words, "--size", "8x6", "-o", tmp_path / "out.npz", "--json")
        told = json.loads(out)
        assert code == 0 and told["scene_hash"] == library.scene("figure-05-sphere").figure_form().resized(8, 6).hash
        assert told["scene_hash"] != library.scene("figure-05-sphere").resized(8, 6).hash
    code, _, err = run(capsys, "render", "effect-shadow", "--as-published", "-o", tmp_path / "out.npz")
    assert code == 2 and "as_published" in err
