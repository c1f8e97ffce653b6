"""The tools for the published figures: a fit finds back numbers that are known, a match tells what was changed."""

import json

import numpy as np
import pytest

from raytruth.reference_tracer.errors import InputError
from raytruth.reference_tracer.scene import library
from raytruth.reference_tracer.scene.load import parse_scene
from raytruth.reference_tracer.tracer.image_files import write_8_bit
from raytruth.reference_tracer.tracer.render import Renderer
from tools.figures.__main__ import main
from tools.figures.classes import classes
from tools.figures.fit import fit
from tools.figures.match import match
from tools.figures.pixels import METHOD, colors, levels, read_picture

SCENE = {
    "name": "known", "camera": {"fov": 50, "width": 96, "height": 64},
    "objects": [{"surface": {"type": "sphere", "center": [0.3, 0, 5], "r": 1}, "material": {"color": [0.8, 0.5, 0.2]}},
                {"surface": {"type": "plane", "center": [0, -1.2, 0], "a": 0, "b": 1, "c": 0}}],
    "lights": [{"position": [2, 4, 1]}, {"position": [-3, 1, 0], "brightness": [0.3, 0.3, 0.3]}],
    "tracing": {"lights": "balanced", "max_distance": 60}}


def scene(**changes):
    return parse_scene(json.dumps(SCENE | changes).encode())


@pytest.fixture(scope="module")
def picture():
    return levels(scene())


def test_chosen_pixels_are_those_of_the_picture(picture):
    chosen = np.array([5, 96 * 30 + 48, 96 * 63 + 95])
    assert (levels(scene(), chosen) == picture.reshape(-1, 3)[chosen]).all()


def test_a_picture_is_read_as_it_was_written(picture, tmp_path):
    write_8_bit(picture, tmp_path / "known.png")
    assert (read_picture(tmp_path / "known.png") == picture).all()
    (tmp_path / "broken.png").write_bytes(b"\x89PNG\r\n\x1a\n....")
    for name in ("broken.png", "missing.png"):
        with pytest.raises(InputError, match=name):
            read_picture(tmp_path / name)


def test_a_fit_finds_back_the_numbers_of_an_8_bit_picture(picture):
    """From a start that is off by a fifth of the ball's radius, of its place, and by degrees: within four standard errors,
    which rounding to grey levels makes about 1e-3; residuals are those of rounding, uniform within half a level."""
    wrong = scene(camera={"fov": 47, "width": 96, "height": 64}, lights=[{"position": [2.5, 3.4, 1.3]}, SCENE["lights"][1]],
                  objects=[{**SCENE["objects"][0], "surface": {"type": "sphere", "center": [0.1, 0.2, 5], "r": 1.2}},
                           SCENE["objects"][1]])
    free = ["camera.fov", "objects[0].surface.center[0]", "objects[0].surface.center[1]", "objects[0].surface.r",
            "lights[0].position"]
    found = fit(wrong, picture, free, pixels=1500)
    true = np.array([50, 0.3, 0, 1, 2, 4, 1])
    assert found.names[0] == "camera.fov" and len(found.names) == 7
    assert (np.abs(found.values - true) < 4 * found.errors + 1e-6).all() and (found.errors < 0.02 * np.maximum(1, true)).all()
    assert found.median < 0.3 and found.rms == pytest.approx(1 / np.sqrt(12), abs=0.08)
    off = np.abs(np.array([47, 0.1, 0.2, 1.2, 2.5, 3.4, 1.3]) - true)
    assert (off > 10 * found.errors).all()  # the start would not have passed


def test_a_fit_of_the_wrong_model_says_so(picture):
    """The plain sum in place of F1 (decision L1): no numbers make the picture, and residuals stay above rounding's."""
    wrong = scene(tracing={"lights": "sum", "max_distance": 60})
    found = fit(wrong, picture, ["lights[0].position", "lights[1].position"], pixels=800)
    assert found.median > 0.5  # what rounding leaves is never more


@pytest.mark.parametrize("free, word", [("camera.angle", "not in the scene"), ("lights[7].position", "not in the scene"),
                                        ("name", "not a number"), ("camera..fov[", "read like")])
def test_what_cannot_be_fitted_is_refused(picture, free, word):
    with pytest.raises(InputError, match=word):
        fit(scene(), picture, [free])


def test_a_match_tells_one_switch_from_the_other():
    """A figure made by the figure's form itself: all pixels match, and each switch changes those that it alone explains."""
    glass = {"surface": {"type": "sphere", "center": [-1.2, -0.4, 4], "r": 0.6},
             "material": {"transparency": 0.8, "refractive_index": 1.3}}
    text = scene(name="figure-05-test", tracing={"max_distance": 60}, objects=[*SCENE["objects"], glass],
                 as_published={"tracing": {"lights": "balanced", "shadows": "opaque_only"}})
    figure = text.figure_form()
    picture = levels(figure)
    found = match(text, picture)
    assert found["figure_form"] == {"within_1": 100.0, "equal": 100.0} and found["left"] == {} and found["rest"] == 0
    first, second = found["switches"]
    assert (first["id"], second["id"]) == ("F1", "F3")
    apart = lambda a, b: 100 * (np.abs(levels(a).astype(int) - levels(b)).max(axis=2) > 1).mean()
    assert first["alone"] == pytest.approx(apart(figure, figure.traced_with(lights="sum")), abs=1e-3) and first["alone"] > 5
    assert second["alone"] == pytest.approx(apart(figure, figure.traced_with(shadows="attenuate")), abs=1e-3)
    assert second["in_turn"] == pytest.approx(apart(figure.traced_with(lights="sum"), text), abs=1e-3) and second["in_turn"] > 0
    assert found["text_form"]["in_turn"] == 0  # the two switches are all there is
    assert found["text_form"]["within_1"] == pytest.approx(100 - apart(figure, text), abs=1e-3)


def test_classes_of_pixels():
    """Of the ball's outline, of its shadow's, and of a lit floor far from both."""
    form = scene(lights=SCENE["lights"][:1])
    rgb = levels(form).astype(int)
    index = np.arange(96 * 64).reshape(64, 96)
    # the colour of the ball is not grey: where grey meets colour is its outline
    ball = np.ptp(rgb, axis=2) > 0
    lit = rgb.max(axis=2) > 0
    outline = index[:, :-1][(ball[:, :-1] != ball[:, 1:]) & lit[:, :-1] & lit[:, 1:]]
    assert classes(form, outline)["silhouette"] == len(outline) > 5
    black = rgb.max(axis=2) == 0
    floor = ~ball & (np.arange(64)[:, None] > 45)
    edge = index[:, 1:-2][floor[:, 1:-2] & floor[:, 2:-1] & (black[:, 1:-2] != black[:, 2:-1])]
    found = classes(form, edge)
    assert found["shadow edge"] + found["silhouette"] == len(edge) > 3 and found["shadow edge"] > 0
    assert classes(form, index[60, 5:9]) == {"smooth": 4, **dict.fromkeys(
        ("belt of the heart", "silhouette", "shadow edge", "range end", "edge in a mirror", "shadow edge in a mirror"), 0)}


def test_the_command(tmp_path, capsys):
    name = "figure-05-sphere"
    own = levels(library.find(f"{name}@published"))
    write_8_bit(own, tmp_path / f"{name}.png")
    out = tmp_path / "found.json"
    assert main(["match", str(tmp_path), name, "--pixels", "3000", "-o", str(out)]) == 0
    found = json.loads(out.read_text())[name]
    assert found["pixels"] == 3000 and found["figure_form"]["equal"] == 100 and str(tmp_path) not in out.read_text()
    own[::2] = 255 - own[::2]
    write_8_bit(own, tmp_path / f"{name}.png")
    assert main(["match", str(tmp_path), name, "--pixels", "3000"]) == 1
    assert main(["match", str(tmp_path), "figure-07-torus"]) == 2 and "Figure 7" in capsys.readouterr().err
    write_8_bit(own[:100], tmp_path / f"{name}.png")
    assert main(["match", str(tmp_path), name]) == 2 and "640 x 100" in capsys.readouterr().err


def test_a_recording_replays_other_numbers():
    """Of a scene with other places, radii, lights, field of view and samples, bit for bit."""
    chosen = np.arange(0, 96 * 64, 11)
    other = scene(camera={"fov": 44, "width": 96, "height": 64, "position": [0.1, 0, 0]}, lights=[{"position": [1, 5, 0]},
                  {"position": [-2, 2, 1], "brightness": [0.4, 0.2, 0.1]}], tracing=SCENE["tracing"] | {"max_distance": 40},
                  objects=[{"surface": {"type": "sphere", "center": [0, 0.1, 4], "r": 1.3}}, SCENE["objects"][1]])
    recorded = Renderer(scene(), METHOD)
    first = colors(scene(), chosen, recorded)
    assert (colors(other, chosen, recorded) == colors(other, chosen)).all() and (first == colors(scene(), chosen)).all()


def test_colours_are_linear(picture):
    chosen = np.arange(0, 96 * 64, 97)
    assert np.abs(255 * colors(scene(), chosen).clip(0, 1) - picture.reshape(-1, 3)[chosen]).max() <= 0.5 + 1e-9
