"""check-image: right pictures pass, wrong ones fail, and the mistake that somebody made is the one that is named.

The wrong pictures come from a C++ port with its text changed (wrong_ports.py); what names them is NumPy.
"""

import json

import numpy as np
import pytest
import wrong_ports
from wrong_ports import CHANGES, SCENE, SCENES, WRITERS

from raytruth.cli import main
from raytruth.comparisons.ports import image_check
from raytruth.comparisons.ports.image_check import check, sized
from raytruth.comparisons.ports.mistaken import Tracers, rendered
from raytruth.comparisons.ports.mistakes import CATALOGUE, NOISY, SWITCHES
from raytruth.comparisons.ports.picture import FinishedPicture
from raytruth.reference_tracer.errors import MissingError
from raytruth.reference_tracer.scene import library
from raytruth.reference_tracer.scene.load import parse_scene
from raytruth.reference_tracer.tracer.image_files import to_8_bit, write_8_bit
from raytruth.reference_tracer.tracer.render import render

SAMPLED = SCENE.resized(40, 30, 2)
OF_SAMPLES = ("samples-at-corners", "divided-by-n")
TEN = ("figure-04-plane", "figure-05-sphere", "figure-06-ellipsoid", "figure-07-torus", "figure-08-paraboloid", "figure-09-heart",
       "effect-shading", "effect-shadow", "effect-reflection", "effect-refraction")


@pytest.fixture(autouse=True)
def truths_kept(monkeypatch, kept={}):  # noqa: B006  one for all tests
    def remembered(scene, method, planes):
        key = scene.hash, method
        if key not in kept:
            kept[key] = render(scene, method, planes=planes)
        return kept[key]

    monkeypatch.setattr(image_check, "render", remembered)


@pytest.fixture(scope="module")
def ports():
    try:
        wrong_ports.program()
    except MissingError as error:
        pytest.skip(str(error))


def in_bytes(color):
    return FinishedPicture(color / 255, 255, 8, ())


def in_floats(color, bits=64):
    return FinishedPicture(color.astype(f"f{bits // 8}").astype(float), None, bits, ())


def verdict(picture, scene, **options):
    return check(picture, scene, **options)[0]


# --- right pictures ----------------------------------------------------------------------------------------------------
@pytest.mark.parametrize("name", TEN)
def test_right_pictures_pass_and_those_of_other_scenes_fail(name):
    truths = {other: image_check.render(library.scene(other).resized(24, 18, 1), "exact", image_check.PLANES) for other in TEN}
    scene = truths[name].scene
    for method in ("exact", "paper"):
        color = image_check.render(scene, method, image_check.PLANES).color
        for picture in (in_bytes(to_8_bit(color)), in_floats(color, 32), in_floats(color)):
            assert verdict(picture, scene, causes=False).verdict == "pass", (method, picture.bits)
    for other in set(TEN) - {name}:
        assert verdict(in_bytes(to_8_bit(truths[other].color)), scene, causes=False).verdict == "fail", other


def test_single_precision_is_acceptable_and_told_apart_from_right():
    scene = library.scene("effect-shadow").resized(40, 30, 1)
    found = verdict(in_floats(render(scene, "exact", precision=32).color, 32), scene)
    assert found.verdict == "acceptable" and 0 < found.excused == found.differing


def test_the_right_port_passes(ports):
    assert verdict(in_bytes(wrong_ports.written((), SCENE)), SCENE).verdict == "pass"
    assert verdict(in_floats(wrong_ports.color((), SCENE)), SCENE).verdict in ("pass", "acceptable")


# --- one mistake -------------------------------------------------------------------------------------------------------
@pytest.mark.parametrize("id", [*CHANGES, *SCENES, *WRITERS])
def test_a_mistake_is_named_from_8_bits(ports, id):
    scene = SAMPLED if id in OF_SAMPLES else SCENE
    found = verdict(in_bytes(wrong_ports.written((id,), scene)), scene)
    assert found.verdict == "fail" and found.failing > 0
    if id in NOISY:  # what rounding draws is matched in half of the pixels, more or less: it may go unnamed, not misnamed
        assert {cause.id for cause in found.causes} <= {id}
        return
    assert [cause.id for cause in found.causes] == [id], (found.causes, found.note)


# --- several -----------------------------------------------------------------------------------------------------------
@pytest.mark.parametrize("ids", [SWITCHES, ("snell-as-printed", "fixed-axes"), ("range-per-path", "glass-casts-no-shadow"),
                                 ("rows-from-the-bottom", "normal-not-normalised", "gamma"),
                                 ("falls-off", "own-colour-in-full", "pixel-corners")], ids="+".join)
@pytest.mark.parametrize("bits", [8, 64])
def test_mistakes_made_together_are_all_named(ports, ids, bits):
    if bits == 64 and set(ids) & set(WRITERS):
        pytest.skip("a writer's mistake is one of bytes")
    picture = in_bytes(wrong_ports.written(ids, SCENE)) if bits == 8 else in_floats(wrong_ports.color(ids, SCENE))
    found = verdict(picture, SCENE)
    assert {cause.id for cause in found.causes} == set(ids)
    assert found.explained >= 0.99 * found.traced and found.spoiled <= 0.01 * found.beside


def test_an_amount_is_found(ports):
    (cause,) = verdict(in_floats(wrong_ports.color(("ambient",), SCENE)), SCENE).causes
    assert cause.amount == pytest.approx(0.07, abs=1e-5)


# --- none that is known --------------------------------------------------------------------------------------------------
def test_what_no_mistake_explains_is_said_to_be_so():
    """One ball in another place: no classic mistake, and nobody's name is taken in vain."""
    ball = SCENE.objects[2]
    moved = ball.model_copy(update={"surface": ball.surface.model_copy(update={"center": (-1.3, 0.2, 5.5)})})
    objects = (*SCENE.objects[:2], moved, *SCENE.objects[3:])
    wrong = render(SCENE.model_copy(update={"objects": objects}), "exact").color
    found = verdict(in_bytes(to_8_bit(wrong)), SCENE)
    assert found.verdict == "fail" and not found.causes and "no known mistake" in found.note


def test_pixels_that_are_not_finite_fail():
    scene = library.scene("effect-shading").resized(24, 18)
    color = render(scene, "exact").color.copy()
    color[3, 4, 1] = np.nan
    found = verdict(in_floats(color), scene)
    assert (found.verdict, found.non_finite, found.failing) == ("fail", 1, 1)
    assert (found.worst.row, found.worst.col, found.worst.size) == (3, 4, None)


# --- the tracer that names -----------------------------------------------------------------------------------------------
@pytest.mark.parametrize("method", ("exact", "paper"))
def test_without_a_mistake_it_is_the_reference(method):
    wrong = np.abs(rendered(SCENE, {}, literal=method == "paper") - image_check.render(SCENE, method, image_check.PLANES).color)
    assert (wrong.max(axis=-1) > 1e-3).mean() < 0.002


def test_every_mistake_of_the_catalogue_shows():
    """On one scene or the other; a record without a line in mistaken.py, or in `filed`, changes nothing."""
    rows, columns = np.divmod(np.random.default_rng(1).permutation(1200)[:500], 40)
    idle = set(CATALOGUE)
    for scene in (SAMPLED.resized(40, 30, 1), SAMPLED):
        ids = [id for id in idle if CATALOGUE[id].stage != "file"]
        sets = [{}, *({id: CATALOGUE[id].amounts[-1]} for id in ids)]
        colors = Tracers(scene, sets, literal=True).colors(rows, columns)
        idle -= {id for id, c in zip(ids, colors[1:]) if np.abs(c - colors[0]).max() > 1e-4}
    assert {id for id in idle if CATALOGUE[id].stage != "file"} <= {"offset-along-the-ray", "heart-as-printed"}


# --- the command -------------------------------------------------------------------------------------------------------
def test_the_command_tells_and_exits(tmp_path, capsys):
    scene, file, errors = library.scene("effect-shading").resized(40, 30), tmp_path / "a.png", tmp_path / "e.png"
    right = to_8_bit(render(scene, "exact").color)
    write_8_bit(right, file)
    assert main(["check-image", str(file), "effect-shading"]) == 0
    assert "exact: pass" in capsys.readouterr().out
    write_8_bit(np.ascontiguousarray(right[::-1]), file)
    assert main(["check-image", str(file), "effect-shading", "--json", "-o", str(errors)]) == 1
    document = json.loads(capsys.readouterr().out)
    assert [cause["id"] for cause in document["causes"]] == ["rows-from-the-bottom"] and errors.stat().st_size > 100
    assert document["failing"] <= document["pixels"] == 1200
    assert main(["check-image", str(file), "effect-shading"]) == 1
    out = capsys.readouterr().out
    assert "y flipped" in out and "of the 5" in out
    file.write_bytes(b"")
    assert main(["check-image", str(file), "effect-shading"]) == 2
    assert capsys.readouterr().err.count("\n") == 1


# --- scenes that are known as text and as figure ------------------------------------------------------------------------
def test_a_picture_in_the_figures_form_passes_and_the_switches_are_told():
    scene = sized(library.scene("figure-17-scene1"), 60, 45)
    found = verdict(in_floats(render(scene.figure_form(), "paper").color), scene)
    assert found.verdict == "pass" and found.form == "as the figure was published (F1, F2, F3, F4)"


def test_a_picture_that_is_not_in_the_figures_form_is_not_held_against_it():
    scene = sized(library.scene("figure-17-scene1"), 60, 45)
    found = verdict(in_floats(render(scene, "paper").color[::-1]), scene)
    assert [cause.id for cause in found.causes] == ["rows-from-the-bottom"] and {form for form, *_ in found.tried} == {
        "as the scene says"}


def test_a_figures_form_that_a_writer_could_have_made_passes():
    """Seen backwards, the world's axes turn a picture as counting columns from the right does (F5)."""
    scene = parse_scene(json.dumps({
        "name": "backwards", "camera": {"width": 24, "height": 18, "direction": [0, 0, -1]},
        "objects": [{"surface": {"type": "sphere", "center": [0.7, 0.4, -4], "r": 1}}], "lights": [{"position": [1, 2, 0]}],
        "as_published": {"camera": {"v_x": [1, 0, 0], "v_y": [0, 1, 0]}}}).encode())
    shown = render(scene.figure_form(), "paper").color
    assert shown.max() > 0.1 and np.allclose(shown, render(scene, "paper").color[:, ::-1], atol=1e-9)
    found = verdict(in_floats(shown), scene)
    assert found.verdict == "pass" and "F5" in found.form


@pytest.mark.parametrize("changes, ids", [
    ({"lights": "balanced", "ambient": 0.1}, {"balanced-lights", "ambient"}), ({"lights": "balanced"}, {"balanced-lights"})])
def test_some_of_the_figures_switches_are_named_as_differences_from_the_text(changes, ids):
    """Such a picture may be nearer to the figure than to the text: it still is neither."""
    scene = sized(library.scene("figure-17-scene1"), 80, 60)
    found = verdict(in_floats(render(scene.traced_with(**changes), "paper").color), scene)
    assert found.verdict == "fail" and found.form == "as the scene says" and {cause.id for cause in found.causes} == ids
