"""Which pixels of an oracle's picture are excused: those that rounding decides, and no others."""

import json

import numpy as np
import pytest

from comparisons.verdicts import conditioning as module
from comparisons.execution.store import Store
from comparisons.verdicts.conditioning import excused
from comparisons.verdicts.judge import excuses
from reference_tracer.tracer.render import HIT, UNDECIDED, render
from reference_tracer.scene.load import parse_scene

LIMIT = 2e-5
SCENE = parse_scene(json.dumps({
    "name": "ball", "camera": {"width": 48, "height": 36},
    "objects": [{"surface": {"type": "sphere", "center": [0, 0, 3], "r": 1}},
                {"surface": {"type": "plane", "center": [0, -1, 0], "a": 0, "b": 1, "c": 0}}],
    "lights": [{"position": [2, 2, 0]}]}).encode())


@pytest.fixture(scope="module")
def truth():
    picture = render(SCENE, "exact")
    return {name: getattr(picture, name) for name in ("color", "t", "index", "status")}


@pytest.fixture
def asked(monkeypatch):
    """Counts how often the map is measured; it says that rounding moves the pixel (5, 7) by 0.1."""
    bound, calls = np.zeros((36, 48)), []
    bound[5, 7] = 0.1
    monkeypatch.setattr(module, "bound", lambda *_: calls.append(1) or bound)
    return calls


def changed(truth, row, col, by):
    color = truth["color"].copy()
    color[row, col] += by
    return {**truth, "color": color}


def measured(truth, test, tmp_path):
    return excused(SCENE, truth, test, LIMIT, 64, Store(tmp_path, module.FOLDER))


def test_nothing_is_measured_where_all_pixels_are_within_the_limit(truth, asked, tmp_path):
    found = measured(truth, changed(truth, 5, 7, 1e-5), tmp_path)
    assert not asked and found["excused pixels"] == 0 and found["color max not excused"] == pytest.approx(1e-5)


@pytest.mark.parametrize("row, col, by, number, largest", [
    (5, 7, 0.05, 1, 0.0), (5, 7, 0.2, 0, 0.2), (5, 8, 0.05, 0, 0.05), (5, 7, np.nan, 0, np.inf)])
def test_a_pixel_is_excused_as_far_as_rounding_may_move_it(truth, asked, tmp_path, row, col, by, number, largest):
    found = measured(truth, changed(truth, row, col, by), tmp_path)
    assert found["excused pixels"] == number and found["color max not excused"] == pytest.approx(largest)
    assert excuses({**found, "pixels": 48 * 36}, LIMIT)[0].holds == (largest == 0)


def test_undecided_pixels_do_not_count(truth, asked, tmp_path):
    status = truth["status"].copy()
    status[5, 8] = UNDECIDED
    found = measured({**truth, "status": status}, changed(truth, 5, 8, 0.5), tmp_path)
    assert found == {"undecided pixels": 1, "excused pixels": 0, "color max not excused": 0.0}


@pytest.mark.parametrize("apart, number", [(0.0, 1), (1e-9, 0)])
def test_a_ray_through_an_edge_is_excused_if_both_objects_are_as_far(truth, asked, tmp_path, apart, number):
    row, col = np.argwhere((truth["index"] == 0) & (truth["status"] == HIT))[0]
    test = changed(truth, row, col, 0.5)
    test["index"], test["t"] = truth["index"].copy(), truth["t"].copy()
    test["index"][row, col], test["t"][row, col] = 1, truth["t"][row, col] * (1 + apart)
    assert measured(truth, test, tmp_path)["excused pixels"] == number


def test_many_excused_pixels_are_no_excuse():
    metrics = {"pixels": 640 * 480, "color max not excused": 0.0, "undecided pixels": 0}
    assert [excuses({**metrics, "excused pixels": n}, LIMIT)[1].holds for n in (107, 200)] == [True, False]


def test_the_map_is_measured_once_and_made_again_where_it_is_truncated(truth, tmp_path, monkeypatch):
    """The ball's silhouette hangs on rounding, the middle of the ball does not."""
    kept = Store(tmp_path, module.FOLDER)
    found = module.bound(SCENE, 32, kept)
    assert found.shape == (36, 48) and found[18, 24] < 1e-4
    with monkeypatch.context() as patch:
        patch.setattr(module, "sensitivity", None)  # measuring once more would fail
        assert (module.bound(SCENE, 32, kept) == found).all()
    file, = kept.folder.glob("*.npz")
    file.write_bytes(file.read_bytes()[:-100])
    assert (module.bound(SCENE, 32, kept) == found).all() and kept.arrays(file.stem) is not None
