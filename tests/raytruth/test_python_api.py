"""raytruth from Python: what the module's own text shows works, is typed, and judges as the suites do."""

import ast
import inspect
import io
import subprocess
import sys
from pathlib import Path

import numpy as np
import OpenImageIO as oiio
import pytest
import trimesh

import raytruth as rt
from raytruth.reference_tracer.tracer.image_files import to_8_bit

HERE = Path(rt.__file__).parent


@pytest.fixture(scope="module")
def scene():
    return rt.Scene(name="built", objects=(rt.Object(name="ball", surface=rt.Sphere(center=(-0.5, 0.0, 4.0), r=1.0), material=rt.Material(color=(0.9, 0.4, 0.2))),
                                           rt.Object(name="ring", surface=rt.Torus(center=(0.6, 0.2, 3.5), R=0.7, r=0.25))),
                    lights=(rt.Light(position=(2.0, 3.0, 0.0)),), camera=rt.Camera(width=48, height=36))


@pytest.fixture(scope="module")
def picture(scene):
    return rt.render(scene)


# --- the module ------------------------------------------------------------------------------------------------------
def test_dir_shows_the_api_and_every_name_is_there():
    assert dir(rt) == sorted(rt.__all__) and {"load_scene", "find_scene", "render", "Picture", "mesh", "compare", "export"} <= set(dir(rt))
    for name in rt.__all__:
        assert getattr(rt, name) is not None
    with pytest.raises(AttributeError, match="no attribute 'rendre'"):
        rt.rendre


def test_type_checkers_are_told_the_same_names():
    """What stands under TYPE_CHECKING, which nobody runs, against what is imported when it is used."""
    block = next(node for node in ast.parse((HERE / "__init__.py").read_text()).body
                 if isinstance(node, ast.If) and getattr(node.test, "id", "") == "TYPE_CHECKING")
    told = {alias.asname or alias.name: (node.module.removeprefix("raytruth."), alias.name)
            for node in block.body for alias in node.names}
    assert told == rt._HOME and set(told) == set(rt.__all__)
    for package in ("raytruth", "reference_tracer", "converters", "comparisons"):
        assert (HERE.parent / package / "py.typed").exists()


@pytest.mark.parametrize("name", sorted(rt.__all__))
def test_every_function_is_documented_and_typed(name):
    thing = getattr(rt, name)
    assert thing.__doc__
    if inspect.isfunction(thing):
        signature = inspect.signature(thing)
        assert signature.return_annotation is not inspect.Signature.empty
        assert all(p.annotation is not inspect.Parameter.empty for p in signature.parameters.values())


def test_importing_is_quick_and_loads_nothing_large():
    program = "import sys, raytruth; dir(raytruth); print([m for m in ('drjit', 'mitsuba', 'numpy', 'trimesh') if m in sys.modules])"
    assert subprocess.run([sys.executable, "-c", program], capture_output=True, text=True).stdout.strip() == "[]"


# --- pictures --------------------------------------------------------------------------------------------------------
def test_a_built_scene_renders_and_the_picture_shows_itself(scene, picture, tmp_path):
    hit = picture.index == 0
    away = np.linalg.norm(picture.position[hit] - [-0.5, 0.0, 4.0], axis=1)
    assert hit.sum() > 50 and np.abs(away - 1).max() < 1e-12
    shown = picture._repr_png_()
    assert shown.startswith(b"\x89PNG")
    (tmp_path / "shown.png").write_bytes(shown)
    np.testing.assert_array_equal(oiio.ImageBuf(str(tmp_path / "shown.png")).get_pixels(oiio.UINT8), to_8_bit(picture.color))
    assert repr(picture) == "<Picture of built, 48 x 36, by exact>"
    assert rt.render(scene, planes=("t",))._repr_png_() is None


def test_mesh_is_trimesh_of_one_object(scene):
    ball, ring = rt.mesh(scene, "ball", cells=32), rt.mesh(scene, 1, cells=32)
    assert isinstance(ball, trimesh.Trimesh) and ball.is_watertight and ring.euler_number == 0
    assert np.abs(np.linalg.norm(ball.vertices - [-0.5, 0.0, 4.0], axis=1) - 1).max() < 1e-14
    middles = np.abs(np.linalg.norm(ball.triangles_center - [-0.5, 0.0, 4.0], axis=1) - 1).max()
    assert ball.metadata["error_bound"] / 4 < middles <= ball.metadata["error_bound"]
    with pytest.raises(rt.InputError, match="built: has no object 'cube'"):
        rt.mesh(scene, "cube")


def test_export_is_the_commands(scene, tmp_path, capsys):
    from raytruth.cli import main

    done = rt.export(scene, tmp_path / "a.ply", "ring", 16)
    (tmp_path / "scene.json").write_text(scene.model_dump_json(by_alias=True, exclude_none=True))
    assert main(["export", str(tmp_path / "scene.json"), "-o", str(tmp_path / "b.ply"), "--object", "ring", "--cells", "16"]) == 0
    assert (tmp_path / "a.ply").read_bytes() == (tmp_path / "b.ply").read_bytes() and done.told[0] in capsys.readouterr().out


# --- compare ---------------------------------------------------------------------------------------------------------
def altered(picture, **planes):
    return rt.Picture(**{**vars(picture), **planes})


def test_compare_agrees_with_other_methods_and_renderers(scene, picture, tmp_path):
    for other in (rt.render(scene, "descartes"), rt.render(scene, precision=32), rt.render_with("embree", scene)):
        found = rt.compare(picture, other, tmp_path)
        assert found.verdict == "agrees" and str(found) == f"agrees: {found.reason}", found
        assert all(gate.holds for gate in found.gates) and found.metrics["differing pixels"] == 0
    assert list(tmp_path.rglob("*.npz"))


def test_compare_notices_what_is_wrong(scene, picture, tmp_path):
    brighter = picture.color.copy()
    brighter[18, 20] += 1e-3
    found = rt.compare(picture, altered(picture, color=brighter), tmp_path)
    assert found.verdict == "differs" and found.metrics["differing pixels"] == 1 and "differing pixels is 1 (1 in color)" in found.reason
    assert found.worst[0] == {"row": 18, "col": 20, "error": pytest.approx(1e-3)}
    # two millionths are much for double precision, and nothing for single
    nearly = altered(picture, t=picture.t * (1 + 2e-7), position=picture.position)
    assert rt.compare(picture, nearly, tmp_path).verdict == "differs"
    nearly.metadata = {**picture.metadata, "renderer": "mine", "precision": 32}
    assert rt.compare(picture, nearly, tmp_path).verdict == "agrees"
    nearly.metadata = {"renderer": "mine", "errors": [None, 0.0]}
    unknown = rt.compare(picture, nearly, tmp_path)
    assert unknown.verdict == "not compared" and "not measurable" in unknown.reason
    moved = scene.objects[0].model_copy(update={"surface": rt.Sphere(center=(-0.5, 0.0, 4.001), r=1.0)})
    other = rt.render(scene.model_copy(update={"objects": (moved, scene.objects[1])}))
    assert rt.compare(picture, altered(other, scene=scene), tmp_path).verdict == "differs"
    elsewhere = altered(picture, color=brighter)  # its scene may be another one: what differs tells nothing
    elsewhere.metadata = {**picture.metadata, "not proven": "a ball may hide a light"}
    found = rt.compare(picture, elsewhere, tmp_path)
    assert found.verdict == "not compared" and "a ball may hide a light" in found.reason


def test_compare_holds_the_literal_method_against_its_oracle(scene, picture, tmp_path):
    coarse = scene.traced_with(step_size=0.7)
    found = rt.compare(rt.render(coarse), rt.render(coarse, "paper"), tmp_path)
    assert found.verdict == "expected" and found.metrics["oracle mismatches"] == 0
    wrong = rt.render(coarse, "paper")
    wrong.t[10:20, 10:30] += 0.01
    assert rt.compare(rt.render(coarse), wrong, tmp_path).verdict == "differs"


def test_compare_is_the_judge_of_the_suite(scene, picture, tmp_path):
    """The same gates, with the same numbers, as `raytruth compare` writes of the same two pictures."""
    from raytruth.comparisons.suite import Options, compare

    results = compare([scene], Options(folder=tmp_path, renderers=("mitsuba-native",), jobs=1, with_studies=False))
    theirs, = results.comparisons
    ours = rt.compare(picture, rt.render_with("mitsuba-native", scene), tmp_path)
    assert (ours.verdict, ours.reason, ours.gates) == (theirs.verdict, theirs.reason, tuple(theirs.gates))


@pytest.mark.parametrize("fault, sentence", [
    (lambda s, p: rt.render(s, planes=("color",)), "the plane t of <Picture of built, 48 x 36, by exact> must be an array of shape"),
    (lambda s, p: altered(p, color=p.color[:-1]), r"must be an array of shape \(36, 48, 3\); found \(35, 48, 3\)"),
    (lambda s, p: rt.render(s.traced_with(max_distance=29.0)), "compare two pictures of one scene")])
def test_what_cannot_be_compared_is_one_sentence(scene, picture, fault, sentence):
    with pytest.raises(rt.InputError, match=sentence):
        rt.compare(picture, fault(scene, picture))


def test_the_modules_text_runs(tmp_path, monkeypatch):
    """Every line of the example in `help(raytruth)`, but the window that shows a mesh."""
    lines = [line.strip() for line in rt.__doc__.splitlines() if line.startswith("    ")]
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "stdout", told := io.StringIO())
    names = {}
    for line in lines:
        exec(line.removesuffix(".show()                          # a trimesh.Trimesh"), names)
        if line.startswith("scene = rt.Scene"):
            names["scene"] = names["scene"].resized(64, 48)
    assert told.getvalue().startswith("agrees: ") and {p.name for p in tmp_path.iterdir()} == {"torus.exr", "torus.pov"}
