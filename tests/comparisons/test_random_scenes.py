"""Random scenes: the oracle against closed forms, a fixed part of the scenes, and wrong tracers that must be noticed."""

import contextlib
import json
import math
from dataclasses import replace

import drjit as dr
import pytest
from flint import arb

from raytruth.cli import main
from raytruth.comparisons.random_scenes import grammar, suite, worker
from raytruth.comparisons.random_scenes.arithmetic import Formula, Taylor, rational
from raytruth.comparisons.random_scenes.judge import Judge
from raytruth.comparisons.random_scenes.oracle import NOTHING, NotDefined, Oracle, Unsettled, precision
from raytruth.reference_tracer.first_hit import bounded_quadric, segments
from raytruth.reference_tracer.scene.load import parse_scene
from raytruth.reference_tracer.tracer.families import Member
from raytruth.reference_tracer.tracer.rays import Sides
from raytruth.reference_tracer.tracer.render import render
from raytruth.reference_tracer.tracer.world import World

FEW = (16, 32, 88, 128, 136, 144, 168, 184, 208, 216)  # of many kinds


def scene(formula, camera=(0, 0, -4), **tracing):
    return {"camera": {"position": list(camera), "direction": [0, 0, 1], "width": 3, "height": 3, "fov": 60},
            "objects": [{"surface": {"type": "expression", "formula": formula}}],
            "lights": [{"position": [0, 0, -10]}], "tracing": tracing}


def straight_ahead(formula, **more):
    oracle = Oracle(scene(formula, **more))
    ray = oracle.camera_ray(1, 1)
    return oracle, ray, oracle.first_hit(ray)


# --- the oracle --------------------------------------------------------------------------------------------------------
@pytest.mark.parametrize("formula, distance", [
    ("x**2 + y**2 + z**2 - 1", 3), ("1e300*(x**2 + y**2 + z**2 - 1)", 3), ("(x**2 + y**2 + z**2 - 1)**5*1e-300", 3),
    ("(x**2 + y**2 + z**2 - 1)*(z + 2)**2", 3), ("(x**2 + y**2 + z**2 - 1)*(z + 2)", 2), ("sqrt(x*x + y*y + z*z) - 1", 3),
    ("abs(x)**2.5 + abs(y)**2.5 + abs(z)**2.5 - 1", 3), ("(abs(x) + abs(y) + abs(z) - 1)**3", 3),
    ("log(x*x + y*y + z*z)", 3), ("cbrt(x*x + y*y + z*z) - 1", 3), ("max(max(abs(x), abs(y)), abs(z)) - 1", 3),
    ("exp(z + 1) - 1 + x*x", None), ("x**2 + y**2 - 1", None), ("(x**2 + y**2 + z**2 - 1)**2", None)])
def test_the_oracle_finds_the_first_change_of_sign(formula, distance):
    _, _, hit = straight_ahead(formula) if "exp" not in formula else straight_ahead(formula, camera=(0, 0, 4))
    if distance is None:
        assert hit.index == NOTHING
    else:
        assert hit.index == 0 and abs(hit.t - distance) < arb(2) ** -100


def test_the_oracle_shades_a_ball():
    oracle = Oracle({**scene("x**2 + y**2 + z**2 - 1"), "lights": [{"position": [5, 0, -5]}]})
    ray = oracle.camera_ray(1, 1)
    hit = oracle.first_hit(ray)
    assert [float(c) for c in oracle.normal_at(ray, hit)] == pytest.approx([0, 0, -1], abs=1e-15)
    # from (0, 0, -1) the light lies in the direction (5, 0, -4)
    assert float(oracle.color(ray)[0]) == pytest.approx(4 / math.hypot(5, 4), abs=1e-15)


def test_the_oracle_says_what_it_cannot_tell():
    with pytest.raises(NotDefined):  # log(z) has no value on the ray's first part
        straight_ahead("log(z) + 1 + 0*x")
    with pytest.raises(Unsettled, match="at the camera"):
        straight_ahead("z + 4")
    oracle = Oracle({**scene("x**2 + y**2 + z**2 - 1"), "objects": scene("x**2 + y**2 + z**2 - 1")["objects"] * 2})
    assert oracle.first_hit(oracle.camera_ray(1, 1)).rivals == (1,)


@pytest.mark.parametrize("formula, value, slope, half_curvature", [  # of t = x at 1/4 and, by hand, the derivatives
    ("x**3", 1 / 64, 3 / 16, 3 / 4), ("sqrt(x)", 1 / 2, 1.0, -1.0), ("1/x", 4, -16, 64), ("abs(x - 1)", 3 / 4, -1, 0),
    ("max(x, 1 - x)", 3 / 4, -1, 0), ("(4*x)**1.5", 1, 6, 6), ("exp(0*x)", 1, 0, 0), ("cbrt(4*x)", 1, 4 / 3, -16 / 9),
    ("log(4*x)", 0, 4, -8), ("sin(pi*(x - 0.25))", 0, math.pi, 0), ("cos(x - 0.25)", 1, 0, -1 / 2),
    ("tan(x - 0.25)", 0, 1, 0)])
@precision()
def test_formulas_are_enclosed_with_their_derivatives(formula, value, slope, half_curvature):
    found = Formula(formula).taylor([arb("0.25")] * 3, [arb(1)] * 3)
    for ball, expected in ((found.value, value), (found.slope, slope), (found.half_curvature, half_curvature)):
        assert abs(float(ball.mid()) - expected) < 1e-14 and float(ball.rad()) < 1e-50
    wide = Formula(formula).taylor([arb("0.25", "0.125")] * 3, [arb(1)] * 3)
    for k in range(9):  # a ball of t holds the values at its points
        t = rational(0.125 + k / 32)
        point = Formula(formula).taylor([arb(t)] * 3, [arb(1)] * 3)
        assert wide.value.contains(point.value) and (wide.slope.contains(point.slope) or not wide.slope.is_finite())


@precision()
def test_formulas_whose_kinks_lie_in_the_ball_keep_what_is_known():
    kink = Formula("abs(x)").taylor([arb(0, 1)] * 3, [arb(1)] * 3)
    assert kink.value.contains(1) and kink.slope.contains(1) and kink.slope.contains(-1) and kink.positive
    assert not Formula("max(abs(x) - 0.5, 0)**2").taylor([arb(0, "0.1")] * 3, [arb(1)] * 3).slope.contains(1)
    assert isinstance(Formula("sqrt(x*x)").taylor([arb(0, 1)] * 3, [arb(1)] * 3), Taylor)


# --- the scenes --------------------------------------------------------------------------------------------------------
def test_a_seed_is_a_scene():
    assert grammar.draw(17).scene == grammar.draw(17).scene != grammar.draw(18).scene
    formula = lambda seed: grammar.draw(seed).scene["objects"][0]["surface"]["formula"]
    assert formula(16) == formula(16 + grammar.SHARED - 1) != formula(16 + grammar.SHARED)
    assert {grammar.draw(k).kind for k in range(0, 1600, grammar.SHARED)} == {*grammar.SOLIDS, "pairs"}


@pytest.mark.parametrize("seed", FEW)
def test_exact_holds_on_random_scenes(seed):
    answer = worker.judged(seed, "exact")
    assert not answer.get("fault") and answer["wrong"] == [] and answer["counts"]["pixels"] == worker.JUDGED


@pytest.mark.parametrize("seed, switch", [(395, "lights"), (555, "ambient"), (1435, "shadows"), (131, "v_x")])
def test_a_picture_without_a_switch_of_its_scene_is_noticed(seed, switch):
    drawn = grammar.draw(seed).scene
    kept = lambda part: {key: value for key, value in drawn[part].items() if key not in (switch, switch.replace("x", "y"))}
    assert kept("tracing") != drawn["tracing"] or kept("camera") != drawn["camera"]
    pixels = [(row, column) for row in range(2, 7) for column in range(3, 9)]
    picture = lambda document: render(parse_scene(json.dumps(document).encode()), "exact", threads=1)
    assert not Judge(drawn).judge(picture(drawn), pixels).wrong
    assert len(Judge(drawn).judge(picture({**drawn, "tracing": kept("tracing"), "camera": kept("camera")}), pixels).wrong) > 4


def test_the_oracle_shares_a_range_along_a_path():
    """A corridor of mirrors, met at 2, 6, 10, ... : (1 - R) R^k each, the background behind the last that is reached."""
    corridor = scene("2 - z", camera=(0, 0, 0), max_distance=11, range="path") | {
        "lights": [{"position": [0, 0, 0]}], "background": [0.25] * 3}
    corridor["objects"] = [{"surface": {"type": "expression", "formula": f}, "material": {"reflection": 0.5}}
                           for f in ("2 - z", "z + 2")]
    for shared, mirrors in (("path", 3), ("ray", 9)):
        corridor["tracing"]["range"] = shared
        oracle = Oracle(corridor)
        assert float(oracle.color(oracle.camera_ray(1, 1))[0]) == pytest.approx(1 - 0.75 * 0.5**mirrors, abs=1e-15)


# --- wrong tracers -----------------------------------------------------------------------------------------------------
def farther(right):
    def nearest(self, ray):
        hit = right(self, ray)
        return replace(hit, t=hit.t * (1 + 1e-6))
    return nearest


def losing_some(right):
    def first(self, solid, ray, inside, limit):
        crossing = right(self, solid, ray, inside, limit)
        return replace(crossing, found=crossing.found & (ray.d[0] > 0))
    return first


def never_dark(right):
    def transmittance(self, ray, distance, active):
        intensity, undecided = right(self, ray, distance, active)
        return dr.select(active, 1, intensity), undecided
    return transmittance


def stretched(right):
    def normal_at(self, point):
        x, y, z = right(self, point)
        return type(point)(x, y, z * 1.0001)
    return normal_at


FAULTS = {
    "distances off by 1e-6": (World, "nearest", farther, 16, "distance"),
    "closed forms that lose hits": (bounded_quadric.BoundedQuadric, "first", losing_some, 17, "hit"),  # compiled
    "searches that lose hits": (segments.SegmentMethod, "first", losing_some, 216, "hit"),
    "sides turned": (Sides, "test", lambda right: lambda self, index: ~right(self, index), 216, "distance"),
    "shadows forgotten": (World, "transmittance", never_dark, 136, "color"),
    "gradients off": (Member, "normal_at", stretched, 16, "normal")}


@pytest.mark.parametrize("fault", FAULTS)
def test_a_wrong_tracer_is_found(monkeypatch, fault):
    owner, name, wrong, seed, what = FAULTS[fault]
    monkeypatch.setattr(owner, name, wrong(getattr(owner, name)))
    assert any(f": {what}: " in text for text in worker.judged(seed, "exact")["wrong"])


def test_a_method_that_decides_nothing_does_not_hold(monkeypatch):
    right = World.nearest
    monkeypatch.setattr(World, "nearest", lambda self, ray: replace(right(self, ray), undecided=self.arrays.Bool(True)))
    answer = worker.judged(16, "exact")
    counts = answer["counts"]
    assert counts["undecided_hits"] == counts["hits"] > 0 and counts["avoidable_hits"] > 0
    assert not suite.Total.of(suite.Answer(**answer)).holds(answer["kind"])
    assert suite.Total.of(suite.Answer(**answer)).holds(suite.EXCUSED[0])


def test_a_kind_holds_if_its_scenes_together_do(monkeypatch, capsys):
    """One hit of a hundred and one may be undecided; two are too many, and the scene with most of them is named."""
    counts = lambda hits, undecided: {"pixels": 16, "hits": hits, "undecided_hits": undecided, "avoidable_hits": undecided}
    answers = [suite.Answer(1, "sines", [], counts=counts(16, 1)), suite.Answer(2, "sines", [], counts=counts(85, 0))]
    monkeypatch.setattr(suite, "run", lambda *how: iter(answers))
    assert main(["certify", "--random", "2"]) == 0
    assert "\nholds: " in capsys.readouterr().out
    answers.append(suite.Answer(3, "sines", [], counts=counts(16, 2)))
    assert main(["certify", "--random", "3"]) == 1
    out = capsys.readouterr().out
    assert "does not hold: sines: 2.56% of the hits undecided" in out and "2 of 16: seed 3\n" in out
    answers[2:] = [suite.Answer(3, "roots", [], fault="MemoryError: no")]
    assert main(["certify", "--random", "3"]) == 1
    assert "does not hold: roots: 1 scene(s) failed" in capsys.readouterr().out


# --- the command -------------------------------------------------------------------------------------------------------
def test_the_command_adds_up_and_repeats_failures(monkeypatch, capsys, tmp_path):
    command = ["certify", "--random", "2", "--seed", "16", "-o", str(tmp_path / "failures")]
    assert main([*command, "--json"]) == 0
    totals = json.loads(capsys.readouterr().out)
    assert sum(t["scenes"] for t in totals.values()) == 2 and not (tmp_path / "failures").exists()
    assert sum(t["counts"]["pixels"] for t in totals.values()) == 2 * worker.JUDGED

    monkeypatch.setattr(World, "nearest", farther(World.nearest))
    here = lambda count, seed, jobs, method, cluster: (suite.Answer(**worker.judged(k, method)) for k in range(seed, seed + count))
    monkeypatch.setattr(suite, "run", here)
    assert main(command) == 1
    out = capsys.readouterr().out
    assert "raytruth certify --random 1 --seed 16;" in out and "distance: t = " in out
    assert f"does not hold: {grammar.draw(16).kind}: " in out and "decided pixel(s) wrong" in out
    assert json.loads((tmp_path / "failures" / "random-16.json").read_text()) == grammar.draw(16).scene


def test_the_command_refuses_what_it_cannot_do(capsys):
    for wrong in (["--random", "0"], ["--random", "5", "--jobs", "0"], ["figure-05-sphere", "--random", "5"]):
        with contextlib.suppress(SystemExit):  # argparse's own way to end
            assert main(["certify", *wrong]) == 2
        assert "--" in capsys.readouterr().err


def test_a_scene_that_cannot_be_rendered_is_a_failure(monkeypatch):
    monkeypatch.setattr(grammar, "draw", lambda seed: grammar.Drawn(seed, "quadrics", {"objects": []}))
    assert worker.judged(5, "exact")["fault"].startswith("refused: ")


@pytest.mark.parametrize("seed", (16, 136, 144, 216))
def test_the_literal_method_holds_where_it_has_no_choice(seed):
    answer = worker.judged(seed, "paper")
    assert answer["wrong"] == [] and answer["counts"]["hits"] > answer["counts"]["unsettled"]
