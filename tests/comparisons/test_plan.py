"""Plans: what is written renders to the tolerance, and a plan that does not is never handed out as proven."""

import json

import numpy as np
import pytest
from planning_support import BALL, HEIGHT, WIDTH, corridor, scene
from workers import exit_code

from raytruth.cli import main
from raytruth.commands.plan import FEWEST_TURNS, text
from raytruth.comparisons.bench.document import Spread
from raytruth.comparisons.planning import document as results
from raytruth.comparisons.planning import measure
from raytruth.comparisons.planning.search import Decision, Search, Yardstick, deciding
from raytruth.reference_tracer.errors import InputError
from raytruth.reference_tracer.scene.load import load_scene
from raytruth.reference_tracer.tracer.render import render

TOLERANCE = 1e-3


@pytest.fixture(scope="module")
def planned():
    return measure.plan(corridor(), TOLERANCE, turns=1)


def test_a_planned_scene_renders_to_the_tolerance_on_pixels_held_back(planned, tmp_path):
    written, plan = corridor(), planned.plan
    file = tmp_path / "planned.json"
    file.write_text(json.dumps(plan.planned))
    scene_ = load_scene(file)
    assert scene_.name == "small-planned" and "recursion depth" in scene_.description
    change = np.abs(render(scene_, "exact").color - render(written, "exact").color).max(-1)
    held_back = ~deciding(written.hash, HEIGHT, WIDTH)
    assert plan.proof.holds and plan.proof.held_back == held_back.sum() and plan.proof.excused == 0
    assert plan.proof.largest == pytest.approx(change[held_back].max(), rel=1e-6)
    assert 0 < change.max() <= TOLERANCE
    assert np.allclose(planned.change, change, atol=1e-12)


def test_what_is_saved_is_told(planned):
    saved = planned.plan.saved
    assert saved.rays_planned == saved.rays_written * 4 // 9  # generations 0 to 3 of 0 to 8
    assert all(ratio.value > 0 for ratio in (saved.exact, saved.paper, saved.call))
    told = text(planned.plan)
    assert "HOLDS on" in told and "recursion depth" in told and "PROVEN" not in told
    assert "SPEED NOT MEASURED" in told and "FASTER" not in told  # one turn tells nothing


@pytest.mark.parametrize("low, high, turns, says", [
    (1.01, 9.0, FEWEST_TURNS, "FASTER than the scene"), (0.17, 9.04, 9, "NO FASTER"), (0.5, 0.9, 9, "SLOWER than"),
    (2.0, 3.0, FEWEST_TURNS - 1, "SPEED NOT MEASURED")])
def test_faster_is_said_only_where_every_turn_says_so(planned, low, high, turns, says):
    spread = Spread(median=(low * high) ** 0.5, low=low, high=high)
    exact = planned.plan.saved.exact.model_copy(update={"wall": spread, "cpu": spread})
    saved = planned.plan.saved.model_copy(update={"exact": exact, "turns": turns})
    told = text(planned.plan.model_copy(update={"saved": saved}))
    assert says in told and f"({low:.2f} to {high:.2f})" in told


def test_a_plan_that_fails_its_proof_is_given_up(monkeypatch):
    """The deciding half sees only the empty left side, and would drop the ball on the right one."""
    left = np.zeros((HEIGHT, WIDTH), bool)
    left[:, :WIDTH // 2] = True
    monkeypatch.setattr(measure, "deciding", lambda *_: left)
    aside = {"surface": {"type": "sphere", "center": [1.2, 0, 4], "r": 0.5}}
    other = {"surface": {"type": "sphere", "center": [-9, 0, 4], "r": 0.5}}
    written = scene(aside, other, lights=[(0, 0, 0)])
    plan = measure.plan(written, TOLERANCE, turns=1).plan
    assert plan.attempts == 3 and plan.margin == 0 and not plan.decisions  # as written, twice warned
    assert plan.proof.holds and len(plan.planned["objects"]) == 2


def test_decisions_are_withdrawn_if_together_they_exceed_the_tolerance(planned):
    written = corridor()
    fine = Decision("cutoff", "0", "1e-5", "", lambda s: s.traced_with(cutoff=1e-5))
    coarse = Decision("recursion depth", "8", "0", "", lambda s: s.traced_with(max_depth=0))
    measure._withdraw(written, Yardstick(written, TOLERANCE), np.ones((HEIGHT, WIDTH), bool), 0.9, [fine, coarse])
    assert coarse.withdrawn and not fine.withdrawn
    assert not coarse.record().changed and coarse.record().planned == "8"


def test_decisions_of_one_kind_are_judged_together(monkeypatch):
    """Leaving out generation 3 changes a pixel by 1e-3, dimmer light by 5e-4: each is within 1.35e-3, both are not."""
    def dimmer(s):
        return s.model_copy(update={"lights": tuple(
            light.model_copy(update={"brightness": (1 - 5e-4,) * 3}) for light in s.lights)})

    def decide(search):
        for change in (lambda s: s.traced_with(max_depth=2), dimmer):
            fits = search.holds("", change)
            yield Decision("", "", "", "", change if fits else None, search.tried())

    monkeypatch.setattr(measure, "ORDER", (decide,))
    written, pixels = corridor(), np.ones((HEIGHT, WIDTH), bool)
    shallow, dim = measure._decide(Yardstick(written, 1.5e-3), written, pixels, 0.9, 60, lambda *_: None)
    assert [d.trials[0].holds for d in (shallow, dim)] == [True, False]
    assert dim.trials[0].change == pytest.approx(1.5e-3, rel=0.02)
    assert Search(Yardstick(written, 1.5e-3), written, pixels, 1.35e-3, float("inf")).holds("", dimmer)  # alone


def test_a_large_picture_is_searched_on_a_smaller_one():
    small = measure.fitted(scene(BALL).resized(4000, 3000, samples=8))
    rays = small.camera.width * small.camera.height * 64
    assert 0.9 * measure.MOST_SEARCHED < rays <= measure.MOST_SEARCHED
    assert measure.fitted(scene(BALL)) == scene(BALL)


def test_plans_of_several_scenes_share_a_document(planned, tmp_path):
    other = planned.plan.model_copy(update={"scene": "another"})
    for plan in (planned.plan, other, planned.plan):
        results.add(plan, tmp_path)
    document = results.read(tmp_path)
    assert [p.scene for p in document.plans] == ["another", "small"]
    (tmp_path / results.FILE).write_text("{}")
    with pytest.raises(InputError, match="raytruth plan"):
        results.read(tmp_path)


def test_the_command_writes_a_scene_and_a_document(tmp_path, capsys):
    file, output = tmp_path / "small.json", tmp_path / "planned.json"
    file.write_text(scene(BALL).model_dump_json(by_alias=True, exclude_none=True))
    assert main(["plan", str(file), "-o", str(output), "--results", str(tmp_path / "results")]) == 0
    out = capsys.readouterr().out
    assert "HOLDS on" in out and "small, 32 x 24" in out
    assert load_scene(output).name == "small-planned"
    plan, = results.read(tmp_path / "results").plans
    assert plan.planned == json.loads(output.read_text())
    with np.load(tmp_path / "results" / plan.planes) as planes:
        assert planes["color"].shape == (HEIGHT, WIDTH, 3) and planes["change"].max() <= 1e-3


@pytest.mark.parametrize("arguments, says", [
    (["figure-05-sphere", "--tolerance", "0"], "tolerance"),
    (["figure-05-sphere", "--tolerance", "nan"], "tolerance"),
    (["figure-05-sphere", "--limit", "0"], "limit"),
    (["figure-05-sphere", "-o", "planned.png"], "planned.png"),
    (["figure-05-sphere", "figure-07-torus", "-o", "planned.json"], "output"),
    (["no-such-scene"], "no-such-scene"),
    (["figure-05-sphere", "--size", "999999x10"], "size"),
])
def test_bad_input_gets_one_sentence(arguments, says, capsys):
    assert exit_code("plan", *arguments) == 2
    error = capsys.readouterr().err.strip()
    assert says in error and "\n" not in error and error.startswith("raytruth: ")
