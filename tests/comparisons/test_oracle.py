"""The literal method is judged: where its oracle shows the same, a difference is its nature; anything else is a fault."""

import json
import sys

import numpy as np
import pytest

from raytruth.cli import main
from raytruth.comparisons import suite
from raytruth.comparisons.agreement import records
from raytruth.comparisons.execution import pool
from raytruth.comparisons.execution.store import Store
from raytruth.comparisons.verdicts import oracle
from raytruth.comparisons.verdicts.judge import literal
from raytruth.reference_tracer.scene import library
from raytruth.reference_tracer.scene.load import parse_scene
from raytruth.reference_tracer.tracer.render import render

# a mirror and a matte ball over a floor; steps of 0.7 miss rims and shadows
SCENE = parse_scene(json.dumps({
    "name": "balls", "camera": {"width": 48, "height": 36}, "tracing": {"step_size": 0.7, "max_distance": 12, "max_depth": 3},
    "objects": [{"surface": {"type": "sphere", "center": [-0.8, 0, 4], "r": 1}, "material": {"reflection": 0.5}},
                {"surface": {"type": "sphere", "center": [1, 0.2, 5], "r": 1}},
                {"surface": {"type": "plane", "center": [0, -1, 0], "a": 0, "b": 1, "c": 0}}],
    "lights": [{"position": [2, 4, 0]}, {"position": [-3, 3, 1], "brightness": [0.3, 0.3, 0.3]}]}).encode())


def planes(picture):
    return {name: getattr(picture, name).copy() for name in ("color", "t", "index", "normal", "position", "status")}


@pytest.fixture(scope="module")
def pictures():
    return planes(render(SCENE, "exact")), planes(render(SCENE, "paper"))


def held(scene, truth, test, folder):
    return {"pixels": truth["t"].size, **oracle.held(scene, truth, test, Store(folder, "sensitivity"))}


def verdict(scene, truth, test, folder):
    return literal(held(scene, truth, test, folder), scene.tracing.step_size)


def test_what_steps_miss_is_expected_and_every_pixel_is_asked_for(pictures, tmp_path):
    found = held(SCENE, *pictures, tmp_path)
    wrong = int(oracle.differing(*pictures).sum())
    assert found["oracle pixels"] == 48 * 36 and found["pixels unlike exact, asked"] == found["pixels unlike exact"] == wrong > 20
    assert found["oracle mismatches"] == 0
    assert sum(count for name, count in found.items() if name.startswith("cause")) == wrong
    assert literal(found, 0.7)[0] == "expected" and "two roots in one step" in literal(found, 0.7)[1]


def test_small_steps_agree(tmp_path):
    scene = SCENE.traced_with(step_size=0.004).resized(24, 18)
    assert verdict(scene, planes(render(scene, "exact")), planes(render(scene, "paper")), tmp_path)[0] == "agrees"


def lost_on_one_side(p):
    left = np.arange(p["t"].shape[1]) < p["t"].shape[1] // 2  # d.x < 0
    p["index"][:, left], p["t"][:, left], p["color"][:, left] = -1, np.inf, 0


def one_pixel(p):
    p["color"][20, 20, 1] += 1e-6


def one_distance(p):
    row, col = np.argwhere(p["index"] == 1)[0]
    p["t"][row, col] *= 1 + 1e-6


def hole(p):
    row, col = np.argwhere(p["index"] == 0)[40]
    for place in (slice(row, row + 3), slice(col, col + 3)), :
        p["index"][place], p["t"][place], p["color"][place] = -1, np.inf, 0


def not_a_number(p):
    p["color"][3, 3] = np.nan


def single_precision(p):
    p["color"], p["t"] = p["color"].astype(np.float32).astype(float), p["t"].astype(np.float32).astype(float)


def swapped(p):
    p["index"] = np.choose(p["index"] + 1, [-1, 1, 0, 2])


def shifted(p):
    for name in p:
        p[name] = np.roll(p[name], 1, axis=1)


def exact_in_its_place(p):
    p.update(planes(render(SCENE, "exact")))


@pytest.mark.parametrize("wrong", [lost_on_one_side, one_pixel, one_distance, hole, not_a_number, single_precision, swapped,
                                   shifted, exact_in_its_place])
def test_anything_else_differs(pictures, tmp_path, wrong):
    truth, test = pictures
    test = {name: plane.copy() for name, plane in test.items()}
    wrong(test)
    found = verdict(SCENE, truth, test, tmp_path)
    assert found[0] == "differs" and "oracle" in found[1]


def test_the_pixels_asked_for_are_half_at_edges_and_where_it_fails():
    """A picture too large for all of its pixels: everything that differs is asked for, with edges and other pixels."""
    h, w = 300, 400
    index = np.zeros((h, w), int)
    index[:, w // 2:] = 1
    truth = {"index": index, "t": np.ones((h, w)), "color": np.zeros((h, w, 3))}
    test = {"index": index.copy(), "t": np.ones((h, w)), "color": np.zeros((h, w, 3))}
    test["color"][10:20, 10:20] = 1
    pixels = oracle.chosen(SCENE, truth, test)
    assert len(pixels) == len(set(pixels)) >= 2000
    row, col = np.divmod(pixels, w)
    assert ((row // 10 == 1) & (col // 10 == 1)).sum() == 100
    edge = np.abs(col - w / 2 + 0.5) < 1
    assert edge.sum() > 500 and (~edge).sum() > 900


def test_the_heart_s_belt_is_newton_s_fault_not_the_step_s(tmp_path):
    """At h = 0.1 free Newton starts far from the triple root on the belt; the chords there are longer than the step."""
    scene = library.scene("figure-09-heart").resized(80, 60, samples=1).traced_with(step_size=0.1)
    verdict_, reason, _ = verdict(scene, planes(render(scene, "exact")), planes(render(scene, "paper")), tmp_path)
    assert verdict_ == "expected" and "Newton left its step" in reason


def test_where_newton_follows_noise_rounding_explains_a_distance(tmp_path):
    """On the heart's belt the distance moves by far more than rounding when a ray moves by rounding; elsewhere it does not."""
    scene = library.scene("effect-shading").resized(320, 240)
    truth, test = planes(render(scene, "exact")), planes(render(scene, "paper"))
    assert verdict(scene, truth, test, tmp_path)[0] == "expected"
    assert verdict(scene, truth, {**test, "t": test["t"] * (1 + 1e-6)}, tmp_path)[0] == "differs"


LOSES = """
import numpy as np
from raytruth.comparisons import renderers
from raytruth.comparisons.execution import worker
right = renderers.render
def render(name, scene, settings=None):
    picture = right(name, scene, settings)
    if name == "paper":
        left = np.arange(picture.t.shape[1]) < picture.t.shape[1] // 2
        picture.index[:, left], picture.t[:, left], picture.color[:, left] = -1, np.inf, 0
    return picture
renderers.render = render
worker.main()
"""


def test_a_literal_method_that_loses_half_of_all_hits_differs(tmp_path, monkeypatch, capsys):
    """Exit code 1, and nobody else is blamed: neither `exact` nor those who agree with it."""
    monkeypatch.setattr(pool, "COMMAND", (sys.executable, "-c", LOSES))
    file = tmp_path / "balls.json"
    file.write_text(SCENE.model_dump_json(by_alias=True, exclude_none=True))
    assert main(["compare", str(file), "--renderers", "paper,embree", "--no-studies", "--results", str(tmp_path / "r")]) == 1
    told = capsys.readouterr().out
    assert "differs       balls--paper" in told and "agrees        balls--embree" in told
    odd = [d for d in records.read(tmp_path / "r").dissent if not d.expected]
    assert [d.renderers for d in odd] == [["paper"]] and not odd[0].split


def test_what_steps_miss_is_no_vote_against_exact(tmp_path):
    options = suite.Options(tmp_path, renderers=("paper", "embree"), with_studies=False)
    results = suite.compare([SCENE], options)
    assert [c.verdict for c in results.comparisons] == ["expected", "agrees"]
    natural, = records.read(tmp_path).dissent
    assert natural.expected and natural.renderers == ["paper"] and "exact" in natural.against
