"""Which pixels may differ, and how far: what rounding and the errors of surfaces decide, and nothing else."""

import json

import drjit as dr
import numpy as np
import pytest

from raytruth.comparisons.execution.store import Store
from raytruth.comparisons.verdicts import conditioning as module
from raytruth.comparisons.verdicts.conditioning import Accuracy, apart, limits
from raytruth.reference_tracer.scene.load import parse_scene
from raytruth.reference_tracer.tracer.render import UNDECIDED, Renderer, render
from raytruth.reference_tracer.tracer.sensitivity import Displaced, Perturbations
from raytruth.reference_tracer.tracer.world import World

SCENE = parse_scene(json.dumps({
    "name": "ball", "camera": {"width": 48, "height": 36},
    "objects": [{"surface": {"type": "sphere", "center": [0, 0, 3], "r": 1}},
                {"surface": {"type": "plane", "center": [0, -1, 0], "a": 0, "b": 1, "c": 0}}],
    "lights": [{"position": [2, 2, 0]}]}).encode())
BALL, FLOOR = 0, 1


@pytest.fixture(scope="module")
def kept(tmp_path_factory):
    return Store(tmp_path_factory.mktemp("results"), module.FOLDER)


@pytest.fixture
def truth():
    planes = {name: plane for name, plane in vars(render(SCENE, "exact")).items() if isinstance(plane, np.ndarray)}
    return {**planes, "camera": np.zeros(3)}


def copied(planes):
    return {name: plane.copy() for name, plane in planes.items()}


def test_a_pixel_is_held_to_the_errors_of_the_objects_on_its_path(kept, truth):
    """The ball is a mesh, the floor is exact: where no ray meets the ball, limits are those of rounding."""
    rounding, meshed = limits(SCENE, Accuracy(32), kept), limits(SCENE, Accuracy(32, (1e-3, 0.0), (0.0, 0.0)), kept)
    inner = module.largest_around(meshed.risk) == 0
    # the limit of a pixel is the largest around it
    away, ball = inner & (module.largest_around(meshed.touched) == 0) & (truth["index"] == FLOOR), inner & (truth["index"] == BALL)
    assert away.sum() > 100 and ball.sum() > 100
    assert (meshed.color[away] <= 1.01 * rounding.color[away]).all() and (meshed.t[away] <= 1.01 * rounding.t[away]).all()
    assert (meshed.t[ball] > 10 * rounding.t[ball]).all() and (meshed.t[ball] > 1e-3).all()


def test_a_displaced_surface_stays_within_its_limits_and_one_farther_off_does_not(kept, truth):
    held = limits(SCENE, Accuracy(64, (1e-3, 0.0), (0.0, 0.0)), kept)
    for off, differs in ((1e-3, False), (2e-2, True)):
        ball, floor = SCENE.objects
        shrunk = ball.model_copy(update={"surface": ball.surface.model_copy(update={"r": 1 - off})})
        picture = render(SCENE.model_copy(update={"objects": (shrunk, floor)}), "exact")
        found = apart(truth, {**vars(picture), "camera": np.zeros(3)}, held)
        assert (found["differing pixels"] > 0) == differs and (differs or found["excused pixels"] <= found["pixels at risk"])


def turned(angle):
    """A tracer with the ball's normals turned towards x by `angle`."""
    def normal(self, point, index, active):
        found = World.normal(self, point, index, active)
        c, s = float(np.cos(angle)), float(np.sin(angle))
        return dr.select(index == BALL, type(found)(c * found.x + s * found.z, found.y, c * found.z - s * found.x), found)
    return type("Tilted", (World,), {"normal": normal})


def test_normals_within_their_errors_agree_and_others_differ(kept, truth):
    """A mirror ball shows the floor elsewhere when its normals turn, though its surface lies where it should."""
    ball, floor = SCENE.objects
    mirror = ball.model_copy(update={"material": ball.material.model_copy(update={"reflection": 0.8})})
    scene = SCENE.model_copy(update={"objects": (mirror, floor)})
    exact = {**vars(render(scene, "exact")), "camera": np.zeros(3)}
    stated, unstated = (limits(scene, Accuracy(64, (0.0, 0.0), (0.0, 0.0), errors), kept) for errors in ((1e-3, 0.0), ()))
    for angle, differs in ((7e-4, False), (2e-2, True)):
        test = {**vars(Renderer(scene, "exact", world=turned(angle)).picture()), "camera": np.zeros(3)}
        assert (apart(exact, test, stated)["differing pixels"] > 50) == differs
        assert apart(exact, test, unstated)["differing pixels"] > 50
        found = apart(exact, test, stated)
        assert differs or (not found["differing pixels"] and found["excused pixels"] <= found["pixels at risk"]), found
    away = (module.largest_around(stated.touched) == 0) & (truth["index"] == FLOOR)
    assert away.sum() > 100 and (stated.normal[away] <= 1.01 * unstated.normal[away]).all()


def test_normals_turn_at_random_by_no_more_than_asked_and_alike_for_one_seed():
    made = Perturbations(SCENE, "exact", Displaced((0.0, 0.0), (0.0, 0.0), (1e-2, 0.0)))
    pictures = [made.picture(0.0, seed) for seed in (0, 1, 1, 2)]
    straight, one, again, other = (p.normal for p in pictures)
    met = pictures[0].index == BALL
    turn = 2 * np.arcsin(np.linalg.norm(one - straight, axis=-1)[met] / 2)
    assert 0.9e-2 < turn.max() <= 1e-2 * (1 + 1e-12) and turn.mean() == pytest.approx(2 / 3 * 1e-2, rel=0.1)  # of a disc
    assert np.linalg.norm((one - straight)[met].mean(axis=0)) < 2e-3  # no way is preferred
    assert (one[met] == again[met]).all() and (one[met] != other[met]).any(axis=-1).all()
    assert (one[pictures[0].index == FLOOR] == straight[pictures[0].index == FLOOR]).all()


def test_undecided_pixels_judge_nobody_and_are_counted(kept, truth):
    held, test = limits(SCENE, Accuracy(64), kept), copied(truth)
    test["color"][18, 24] += 0.5
    assert apart(truth, test, held)["differing pixels"] == 1
    held.decided[18, 24] = False
    found = apart(truth, test, held)
    assert found["differing pixels"] == 0 and found["undecided pixels"] == 1


@pytest.mark.parametrize("seen, differs", [(True, 0), (False, 1)])
def test_an_edge_excuses_what_is_seen_on_its_other_side_alone(kept, truth, seen, differs):
    """At a pixel of the silhouette, another object may be hit; one that no perturbed ray has met may not."""
    held = limits(SCENE, Accuracy(32, (1e-2, 0.0), (0.0, 0.0)), kept)
    row, col = np.argwhere((held.risk & 1 > 0) & (truth["index"] == BALL) & (truth["color"].max(-1) < 0.3))[0]
    there = next(k for k in (-1, FLOOR) if held.seen[row, col] >> np.uint64(k + 1) & np.uint64(1))
    other = there if seen else next(k for k in (-1, FLOOR) if k != there)
    if not seen:
        held.seen[row, col] &= ~(np.uint64(1) << np.uint64(other + 1))
    test = copied(truth)
    test["index"][row, col] = other
    found = apart(truth, test, held)
    assert found["unforeseen pixels"] == differs and found["excused pixels"] == 1 - differs and not found["differing pixels"]


def test_limits_are_measured_once_and_made_again_where_they_are_truncated(tmp_path, monkeypatch):
    kept = Store(tmp_path, module.FOLDER)
    found = limits(SCENE, Accuracy(32), kept)
    assert found.color.shape == (36, 48) and found.color[18, 24] < 1e-4
    with monkeypatch.context() as patch:
        patch.setattr(module, "response", None)  # measuring once more would fail
        assert (limits(SCENE, Accuracy(32), kept).color == found.color).all()
    file, = kept.folder.glob("*.npz")
    file.write_bytes(file.read_bytes()[:-100])
    assert (limits(SCENE, Accuracy(32), kept).color == found.color).all() and kept.arrays(file.stem) is not None


def test_what_is_undecided_is_not_decided(kept):
    picture = render(SCENE, "exact")
    assert (limits(SCENE, Accuracy(32), kept).decided == (picture.status != UNDECIDED)).all()
