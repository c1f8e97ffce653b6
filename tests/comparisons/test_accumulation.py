"""Results accumulate: one more scene, renderer or case drops no other; what is printed to reproduce a case leaves the rest."""

import json
import shlex
import shutil

import numpy as np
import pytest

from raytruth.cli import main
from raytruth.comparisons import results, suite
from raytruth.comparisons.agreement import records
from raytruth.comparisons.execution.pool import Pool
from raytruth.comparisons.runs import Request, RunStore
from raytruth.comparisons.stability import document as stability
from raytruth.reference_tracer.scene import library
from raytruth.reference_tracer.scene.load import parse_scene
from raytruth.reference_tracer.tracer.image_files import load_npz
from raytruth.reference_tracer.tracer.render import render


def scene(name, radius=1.0):
    return parse_scene(json.dumps({
        "name": name, "camera": {"width": 24, "height": 16}, "tracing": {"step_size": 0.4},
        "objects": [{"surface": {"type": "sphere", "center": [0, 0, 3], "r": radius}}],
        "lights": [{"position": [2, 2, 0]}]}).encode())


def compare(folder, *scenes, renderers=("paper",), **more):
    return suite.compare(scenes, suite.Options(folder, renderers=renderers, with_studies=False, **more))


def rows(folder):
    document, matrix = results.read(folder), records.read(folder)
    return ({c.id for c in document.comparisons}, {s.name for s in document.scenes}, {p.scene for p in matrix.pairs},
            {run.key for run in document.runs})


def test_one_more_scene_drops_no_other_unless_asked(tmp_path):
    compare(tmp_path, scene("one"))
    first = results.read(tmp_path)
    only = compare(tmp_path, scene("two", 0.9))
    assert [c.id for c in only.comparisons] == ["two--paper"]  # what is returned is what was asked for
    ids, names, pairs, keys = rows(tmp_path)
    assert ids == {"one--paper", "two--paper"} and names == pairs == {"one", "two"}
    assert {run.key for run in first.runs} < keys
    again = compare(tmp_path, scene("one", 0.8))  # another scene of the same name takes its place
    assert rows(tmp_path)[0] == ids and results.read(tmp_path).run(again.comparisons[0].test)
    compare(tmp_path, scene("two", 0.9), fresh=True)
    assert rows(tmp_path)[:3] == ({"two--paper"}, {"two"}, {"two"})


def test_one_more_renderer_drops_no_other(tmp_path):
    compare(tmp_path, scene("one"), renderers=("paper", "embree"))
    before = {p.second for p in records.read(tmp_path).pairs}
    compare(tmp_path, scene("one"), renderers=("paper",))
    assert rows(tmp_path)[0] == {"one--paper", "one--embree"} and {p.second for p in records.read(tmp_path).pairs} == before


def test_pages_appear_while_scenes_are_compared_and_the_time_is_told(tmp_path, monkeypatch, capsys):
    from raytruth import reports
    from raytruth.commands import compare as command

    told, build = [], reports.build

    def built(*arguments, **more):
        told.append(build(*arguments, **more).read_text(encoding="utf-8"))

    monkeypatch.setattr(reports, "build", built)
    monkeypatch.setattr(command, "FIRST", (1,))
    for name in ("one", "two"):
        (tmp_path / f"{name}.json").write_text(scene(name).model_dump_json(by_alias=True))
    line = ["compare", str(tmp_path / "one.json"), str(tmp_path / "two.json"), "--renderers", "paper", "--no-studies",
            "-o", str(tmp_path / "results"), "--report", str(tmp_path / "html")]
    assert main(line) == 0
    assert len(told) == 2 and "<b>1 of 2 comparisons so far.</b>" in told[0] and 'href="scenes/one.html"' in told[0]
    assert "so far" not in told[1] and 'href="scenes/two.html"' in told[1]
    capsys.readouterr()
    assert main(["report", "--profile", "--results", str(tmp_path / "results")]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[0].startswith("compare, ") and {"exact", "paper", "limits"} & {line.split()[0] for line in lines[1:]}
    assert main(line) == 0 and len(told) == 3  # all is there: no round before the last
    assert main(["report", "--profile", "--results", str(tmp_path)]) == 2


def test_the_command_printed_with_a_case_works_and_leaves_the_results_alone(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert main(["compare", "effect-shading", "effect-shadow", "--renderers", "paper", "--no-studies", "--largest", "24"]) == 0
    before = results.read("results").model_copy(update={"created": "", "seconds": 0})
    for command in {c.command for c in before.comparisons}:
        program, *arguments = shlex.split(command)
        assert program == "raytruth" and main([*arguments, "--no-studies"]) == 0
    after = results.read("results").model_copy(update={"created": "", "seconds": 0})
    for field in ("scenes", "runs", "comparisons"):
        key = lambda row: row.model_dump_json()
        assert sorted(getattr(after, field), key=key) == sorted(getattr(before, field), key=key)


@pytest.mark.parametrize("renderer, settings, changes", [
    ("exact", {}, {"refraction": "as_printed"}), ("exact", {}, {"max_depth": 1}), ("paper", {"step_size": 0.3}, {}),
    ("mitsuba-mesh", {"resolution": 48}, {}), ("embree", {"resolution": 48}, {}), ("mitsuba-native", {}, {}), ("povray", {}, {})])
def test_the_command_printed_with_a_run_makes_its_picture_again(tmp_path, monkeypatch, renderer, settings, changes):
    if renderer == "povray" and not shutil.which("povray"):
        pytest.skip("needs POV-Ray")
    monkeypatch.chdir(tmp_path)
    base = library.find("effect-total-reflection").resized(24, 18)
    request, made = Request(base.traced_with(**changes), renderer, settings, changes), RunStore(tmp_path / "results")
    with Pool(1) as pool:
        run = made.make(request, pool, 120)
    assert run.state == "ok", run.message
    program, *arguments = shlex.split(run.command)
    assert program == "raytruth" and main(arguments) == 0
    again, kept = (load_npz(file)[0] for file in (tmp_path / f"{base.name}.npz", made.file(run.key)))
    for name in ("color", "t", "position", "normal", "index", "depth", "status"):  # Mitsuba adds up a pixel's rays in any order
        assert np.allclose(again[name], kept[name], rtol=0, atol=1e-12, equal_nan=True), name
    if changes:
        assert not np.array_equal(kept["color"], render(base).color)


def test_one_more_family_drops_no_other(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for family in ("horizon", "printed-refraction", "horizon"):
        assert main(["stability", "--family", family, "--rays", "50", "-o", "results"]) == 0
    assert {f.id for f in stability.read("results").families} == {"horizon", "printed-refraction"}
    assert main(["stability", "--family", "horizon", "--rays", "50", "-o", "results", "--fresh"]) == 0
    assert [f.id for f in stability.read("results").families] == ["horizon"]


@pytest.mark.parametrize("other", ['{"version": 1}', "{", ""])
def test_what_cannot_be_read_is_replaced(tmp_path, other):
    (tmp_path / results.FILE).write_text(other)
    compare(tmp_path, scene("one"))
    assert rows(tmp_path)[0] == {"one--paper"}
