"""A renderer that cannot express a switch is compared without it, on both sides; no scene loses its oracle, and it is told."""

import json
import shutil

import pytest

from raytruth.__main__ import main
from raytruth.comparisons import renderers, suite
from raytruth.comparisons.agreement import records
from raytruth.comparisons.agreement.tightness import HELD
from raytruth.comparisons.attribution.explain import explained
from raytruth.comparisons.renderers import RENDERERS, povray
from raytruth.comparisons.renderers.expressible import EMBREE, MITSUBA, POVRAY
from raytruth.converters.povray import convert
from raytruth.reference_tracer.errors import UnsupportedError
from raytruth.reference_tracer.scene.load import parse_scene
from raytruth.reference_tracer.scene.model import Tracing

BALL = parse_scene(json.dumps({
    "name": "ball", "camera": {"width": 24, "height": 16},
    "objects": [{"surface": {"type": "sphere", "center": [0, 0, 3], "r": 1}}],
    "lights": [{"position": [2, 2, 0], "brightness": [0.9, 0.9, 0.9]}, {"position": [-1, 2, 0], "brightness": [0.8, 0.8, 0.8]}],
    "tracing": {"step_size": 0.005}}).encode())  # nothing is missed
BALANCED = BALL.traced_with(lights="balanced", ambient=0.1)
ODD = {"lights": "balanced", "ambient": 0.1, "shadows": "opaque_only", "range": "path", "refraction": "as_printed",
       "effects": ("shadow",), "cutoff": 0.1, "adaptive": 0.1}
needs_povray = pytest.mark.skipif(shutil.which("povray") is None, reason="POV-Ray is not installed")


@pytest.mark.parametrize("name", RENDERERS)
def test_a_scene_that_asks_for_nothing_unusual_stays_as_it_is(name):
    near = renderers.nearest(BALL, name)
    assert near.scene is BALL and near.words == ""


@pytest.mark.parametrize("name, kept", [
    ("exact", set(ODD)), ("paper", set(ODD)), ("embree", {"lights", "ambient", "shadows", "range", "effects"}),
    ("mitsuba-mesh", {"lights", "ambient", "shadows", "range"}), ("povray", {"ambient", "shadows"})])
def test_what_a_renderer_lacks_is_at_its_default_and_nothing_else(name, kept):
    near = renderers.nearest(BALL.traced_with(**ODD), name)
    changed = {key for key in ODD if getattr(near.scene.tracing, key) != ODD[key]}
    assert changed == set(ODD) - kept
    assert all(set(value) == set(getattr(Tracing(), key)) if key == "effects" else value == getattr(Tracing(), key)
               for key in changed for value in [getattr(near.scene.tracing, key)])
    assert near.scene.model_copy(update={"tracing": BALL.tracing}) == BALL and near.scene.name == "ball"
    assert len(near.words.split("; ")) == len(changed) or (not changed and near.words == "")


def test_the_words_say_what_and_why():
    assert renderers.nearest(BALANCED, "povray").words == "lights added up, because POV-Ray 3.7 adds lights"
    words = renderers.nearest(BALANCED.traced_with(refraction="as_printed"), "embree", "povray").words
    assert words == ("Snell's law, because Embree refracts by no other; lights added up, because POV-Ray 3.7 adds lights")


def test_effects_are_added_and_none_is_taken():
    shadowless = BALL.traced_with(effects=("reflection", "refraction"))
    assert renderers.nearest(shadowless, "povray").scene is shadowless
    assert renderers.nearest(BALL.traced_with(effects=("refraction",)), "povray").scene.tracing.effects == (
        "reflection", "refraction")


@pytest.mark.parametrize("change", [{key: value} for key, value in ODD.items()], ids=lambda change: next(iter(change)))
def test_pov_ray_takes_the_nearest_scene_and_refuses_what_is_not_it(change):
    """The list of what it lacks is neither too short nor too long."""
    scene = BALL.traced_with(**change)
    near = renderers.nearest(scene, "povray")
    convert(near.scene)
    if near.words:
        with pytest.raises(UnsupportedError):
            convert(scene)


# --- in the suite ----------------------------------------------------------------------------------------------------
@pytest.fixture(scope="module")
def results(tmp_path_factory):
    folder = tmp_path_factory.mktemp("results")
    found = suite.compare([BALANCED], suite.Options(folder, ("paper", "embree", "povray"), with_studies=False))
    return found, records.read(folder)


@needs_povray
def test_no_scene_loses_its_oracle_and_the_verdict_says_so(results):
    found, matrix = results
    comparisons = {found.run(c.test).renderer: c for c in found.comparisons}
    near, other = comparisons["povray"], comparisons["embree"]
    assert near.verdict == "agrees" and other.instead == "" and "compared with" not in other.reason
    assert near.instead == "lights added up, because POV-Ray 3.7 adds lights"
    assert near.reason.endswith(f"; compared with {near.instead}")
    # against the truth of that same scene, which is another one than that of the scene as written
    truths = {c.reference for c in (near, other)}
    assert len(truths) == 2 and {found.run(key).renderer for key in truths} == {"exact"}
    assert comparisons["paper"].reference == other.reference
    assert {(p.first, p.second): bool(p.instead) for p in matrix.pairs} == {
        ("exact", "paper"): False, ("exact", "embree"): False, ("exact", "povray"): True, ("paper", "embree"): False,
        ("paper", "povray"): True, ("embree", "povray"): True}
    assert not matrix.absent and all(p.agrees for p in matrix.pairs if "embree" not in (p.first, p.second))


@needs_povray
def test_against_the_scene_as_written_it_would_differ(tmp_path, monkeypatch):
    """POV-Ray's picture of added lights is far from balanced ones: the truth has to be that of the nearest scene."""
    made = povray.render
    monkeypatch.setitem(RENDERERS, "povray", renderers.Renderer(**{**vars(RENDERERS["povray"]), "lacks": ()}))
    refused = suite.compare([BALANCED], suite.Options(tmp_path, ("povray",), with_studies=False)).comparisons[0]
    assert refused.verdict == "not compared" and "F1" in refused.reason
    apart = abs(made(renderers.nearest(BALANCED, "mitsuba-native").scene.traced_with(lights="sum"), planes=False).color
                - renderers.render("exact", BALANCED, {"repeat": False}).color).max()
    assert apart > 0.1


def test_what_differs_is_attributed_on_the_nearest_scene(results, monkeypatch):
    found, _ = results
    asked = []
    monkeypatch.setattr("raytruth.comparisons.attribution.explain.make_all", lambda tasks, *_: asked.extend(tasks) or dict.fromkeys(
        tasks, type("Answer", (), {"judged": None})))
    differing = [c.model_copy(update={"verdict": "differs"}) for c in found.comparisons]
    explained(differing, [BALANCED], {run.key: run for run in found.runs}, None, None)
    assert {task.b: task.scene.tracing.lights for task in asked} == {"paper": "balanced", "embree": "balanced", "povray": "sum"}


def test_limits_are_studied_on_scenes_that_all_can_express():
    for held in HELD:
        scene, = held.expressed([BALL.traced_with(**ODD)])
        for request in held.requests(scene):
            assert renderers.nearest(request.scene, request.renderer).scene is request.scene


@needs_povray
def test_a_single_picture_says_it_as_well(tmp_path, capsys):
    file = tmp_path / "scene.json"
    file.write_text(BALANCED.model_dump_json(by_alias=True, exclude_none=True))
    assert main(["render", str(file), "--with", "povray", "-o", str(tmp_path / "out.npz"), "--json"]) == 0
    told = capsys.readouterr()
    assert "rendered with lights added up, because POV-Ray 3.7 adds lights" in told.err
    assert json.loads(told.out)["scene_hash"] == BALANCED.traced_with(lights="sum").hash


def test_every_switch_is_lacked_or_not_on_purpose():
    """A new parameter of tracing has to be thought of here: which renderers cannot express it?"""
    lacked = {lack.parameter for lacks in (MITSUBA, EMBREE, POVRAY) for lack in lacks}
    everywhere = {"step_size", "tolerance", "max_iterations", "max_distance", "max_depth", "samples", "precision", "ambient",
                  "shadows"}  # of the literal method, of all renderers, or of the truth's own arithmetic
    assert lacked | everywhere == set(Tracing.model_fields) and not lacked & everywhere
    assert lacked <= set(ODD)
