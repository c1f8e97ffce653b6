"""Bad files of planes are told in a sentence."""

import numpy as np
import pytest
from report_support import make_run

from raytruth.reports.figures.planes import NoPlanes, read


def test_good_planes_are_read_exactly(folder, pictures):
    planes = read(make_run("bad"), folder)
    assert np.array_equal(planes.color, pictures["bad"].color, equal_nan=True)
    assert planes.undecided.sum() == 1


@pytest.mark.parametrize("damage, words", [
    (lambda path: path.unlink(), "missing"),
    (lambda path: path.write_bytes(b"garbage"), "cannot be read"),
    (lambda path: path.write_bytes(path.read_bytes()[:400]), "cannot be read"),
    (lambda path: np.savez(path, t=np.zeros((2, 2))), "cannot be read"),
    (lambda path: rewrite(path, color=np.zeros((3, 2, 3))), "plane color has shape (3, 2, 3)"),
    (lambda path: rewrite(path, index=np.full((24, 32), "x")), "plane index does not hold numbers"),
    (lambda path: rewrite(path, t=np.zeros(5)), "plane t has shape (5,)"),
])
def test_bad_planes_are_told(folder, damage, words):
    damage(folder / "runs" / "good.npz")
    with pytest.raises(NoPlanes) as caught:
        read(make_run("good"), folder)
    assert words in str(caught.value)


def rewrite(path, **changes):
    with np.load(path, allow_pickle=False) as file:
        arrays = {**file, **changes}
    np.savez(path, **arrays)


def test_nothing_outside_the_results_is_read(folder, tmp_path):
    (folder / "runs" / "good.npz").rename(tmp_path / "good.npz")
    for place in ("../good.npz", str(tmp_path / "good.npz")):
        with pytest.raises(NoPlanes, match="outside"):
            read(make_run("good").model_copy(update={"planes": place}), folder)
