"""All pairs of real runs: the odd one out is named, absences are told, what was measured is kept."""

import json

import pytest
from workers import MISBEHAVING

from raytruth.comparisons import renderers, suite
from raytruth.comparisons.agreement import matrix, records, tightness
from raytruth.comparisons.agreement.records import Pair
from raytruth.comparisons.execution import pool
from raytruth.comparisons.execution.pool import Silent
from raytruth.comparisons.results import Run
from raytruth.comparisons.runs import Request
from raytruth.comparisons.verdicts import tolerances
from raytruth.comparisons.verdicts.pairs import Measured
from raytruth.comparisons.verdicts.tolerances import DOUBLE, MESH, NATIVE, TRACERS, Tolerance, between
from raytruth.reference_tracer.errors import InputError
from raytruth.reference_tracer.scene.load import parse_scene

SCENE = parse_scene(json.dumps({
    "name": "ball", "camera": {"width": 48, "height": 32},
    "objects": [{"surface": {"type": "sphere", "center": [0, 0, 3], "r": 1}}],
    "lights": [{"position": [2, 2, 0]}], "tracing": {"step_size": 0.005}}).encode())  # nothing is missed
NAMES = ("paper", "embree", "dim", "segfault")


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """The results of the ball by some renderers, one of which makes every picture a tenth too dark, and one crashes."""
    with pytest.MonkeyPatch.context() as patch:
        for way in ("dim", "segfault"):
            patch.setitem(renderers.RENDERERS, way, renderers.Renderer(way, way, "misbehaving", {"way": way}))
        patch.setattr(pool, "COMMAND", MISBEHAVING)
        found = tmp_path_factory.mktemp("results")
        suite.compare([SCENE], suite.Options(found, NAMES, with_studies=False))
        yield found


@pytest.fixture
def compared(folder):
    return records.read(folder)


def test_every_pair_is_there_and_the_wrong_renderer_is_named(compared):
    pairs = {(p.first, p.second): p.agrees for p in compared.pairs}
    assert pairs == {("exact", "paper"): True, ("exact", "embree"): True, ("paper", "embree"): True,
                     ("exact", "dim"): False, ("paper", "dim"): False, ("embree", "dim"): False}
    odd, = compared.dissent
    assert odd.renderers == ["dim"] and odd.against == ["exact", "paper", "embree"] and not odd.expected
    assert "differing pixels" in odd.sentence
    dark = next(p for p in compared.pairs if p.second == "dim" and p.first == "exact")
    # the brightest pixel's cosine is nearly 1
    assert 0.09 < dark.color_max <= 0.1 and dark.mismatches == 0 and dark.depth_p99 == 0
    absent, = compared.absent
    assert absent.renderer == "segfault" and absent.state == "crashed" and "SIGSEGV" in absent.reason


def test_what_was_measured_is_not_measured_again(folder, monkeypatch):
    monkeypatch.setattr(Silent, "end", lambda _, label, *rest: label == "segfault: ball" or pytest.fail(f"again: {label}"))
    before = (folder / records.FILE).read_bytes()
    suite.compare([SCENE], suite.Options(folder, NAMES, with_studies=False))
    assert (folder / records.FILE).read_bytes() == before


def test_a_document_that_is_none_is_one_sentence(tmp_path):
    (tmp_path / records.FILE).write_text('{"version": 1, "pairs": 3}')
    with pytest.raises(InputError, match="raytruth compare"):
        records.read(tmp_path)


def run(renderer, triangles=0, resolution=256, **facts):
    return Run(key=renderer, scene="ball", renderer=renderer, title=renderer, state="ok", command="",
               settings={"resolution": resolution}, facts={"triangles": triangles, **facts})


def test_pairs_are_held_to_the_sum_of_their_tolerances():
    exact, native, mesh = run("exact"), run("mitsuba-native"), run("mitsuba-mesh", 100)
    assert between(exact, run("paper")) is DOUBLE and between(exact, native) is NATIVE and between(mesh, exact) is MESH
    both = between(native, mesh)
    assert both.depth_p99 == NATIVE.depth_p99 + MESH.depth_p99 and both.color_p99 == NATIVE.color_p99 + MESH.color_p99
    assert between(mesh, run("embree", 100)) is TRACERS
    # another mesh is not the same mesh
    for other in (run("embree", 100, 128), run("embree", 90), run("mitsuba-native", 100, native_shapes=1)):
        assert between(mesh, other).depth_p99 == 2 * MESH.depth_p99


def pair(first, second, agrees):
    return Pair(scene="ball", first=first, second=second, agrees=agrees, tolerance="any", broken="" if agrees else "20 pixels differ",
                color_p99=0.0, color_max=0.0, inner_max=0.0, failing=0, mismatches=0, depth_p99=0.0)


@pytest.mark.parametrize("facts, named", [({"not proven": "a ball may hide a light"}, False), ({"not proven": ""}, True)])
def test_who_may_have_been_given_another_scene_is_no_odd_one_and_has_no_vote(facts, named):
    names = ("exact", "mitsuba-mesh", "povray")
    runs = [run(name, **(facts if name == "povray" else {})) for name in names]
    found = [pair("exact", "mitsuba-mesh", True), pair("exact", "povray", False), pair("mitsuba-mesh", "povray", False)]
    told, = matrix.dissent(SCENE, runs, found)
    assert told.renderers == ["povray"] and told.expected != named
    assert ("a ball may hide a light" in told.sentence) != named


def test_what_differs_on_another_scene_tells_nothing(tmp_path, monkeypatch):
    """A renderer that shows something else, and says that its scene may be another one."""
    for module in (tolerances, matrix):
        monkeypatch.setattr(module, "unproven", lambda run: "its scene may be another" if run.renderer == "dim" else "")
    monkeypatch.setitem(renderers.RENDERERS, "dim", renderers.Renderer("dim", "dim", "misbehaving", {"way": "dim"}))
    monkeypatch.setattr(pool, "COMMAND", MISBEHAVING)
    found = suite.compare([SCENE], suite.Options(tmp_path, ("embree", "dim"), with_studies=False))
    verdicts = {c.id.rpartition("--")[2]: c for c in found.comparisons}
    assert verdicts["dim"].verdict == "not compared" and "its scene may be another" in verdicts["dim"].reason


class Numbers:
    """Stands where measurements are: every metric is 0, one of them of the worse run `worse`."""

    def __init__(self, worse):
        self.worse = worse

    def of(self, pair):
        zero = {"pixels": 1000, "interior hit pixels": 100, "not finite": 0, "depth p99": 0.0, "color p99": 1e-4, "differing pixels": 0,
                "excused pixels": 0, "unforeseen pixels": 0, "undecided pixels": 0, "pixels at risk": 0}
        return Measured(metrics={**zero, "color p99": self.worse} if pair.second.settings["resolution"] == 128 else zero)


@pytest.mark.parametrize("worse, verdict", [(2e-3, "tight"), (5e-4, "loose")])
def test_a_limit_is_tight_if_something_worse_exceeds_it(monkeypatch, worse, verdict):
    limit = Tolerance("meshes", "", 1.0, 1e-3)
    monkeypatch.setattr(tightness, "between", lambda *_: limit)
    monkeypatch.setattr(tightness, "HELD", (tightness.Held(limit, "mitsuba-mesh", (tightness.COARSE,)),))
    names = ("mitsuba-mesh",)
    wanted = {r.key: r for r in [*(Request(SCENE, n) for n in ("exact", *names)), *tightness.requests([SCENE], names)]}
    runs = {key: run(r.renderer, 10, r.settings.get("resolution", 256)) for key, r in wanted.items()}
    rows = {row.gate: row for row in tightness.tightness([SCENE], names, runs, Numbers(worse))}
    assert rows["color p99"].verdict == verdict and rows["color p99"].worse_share == pytest.approx(worse / 1e-3)
    assert rows["color p99"].share == pytest.approx(0.1)
    assert rows["depth p99"].verdict == "loose"  # nothing worse comes near it
    assert rows.keys() == {"depth p99", "color p99"}  # what single pixels are held to follows from each run itself
    assert rows["color p99"].command.startswith("raytruth render ball --with mitsuba-mesh --set resolution=128")
