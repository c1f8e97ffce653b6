"""Meshes that outlast a process: one making serves all renderers, and a file that is not whole serves nobody."""

from collections import OrderedDict

import numpy as np
import pytest

from raytruth.comparisons import meshes
from raytruth.comparisons.execution.pool import Pool
from raytruth.comparisons.runs import Request, RunStore
from raytruth.converters.mesh import convert
from raytruth.reference_tracer.scene import library

SCENE = library.scene("figure-07-torus").resized(24, 18, 1)
TORUS = SCENE.objects[0]


@pytest.fixture
def later(monkeypatch):
    """A process that begins: it has no meshes, and makes none unless it is `able`."""
    making = convert._made

    def begin(able: bool = False):
        def made(*arguments):
            assert able, "made again"
            return making(*arguments)

        monkeypatch.setattr(convert, "_kept", OrderedDict())
        monkeypatch.setattr(convert, "_made", made)

    monkeypatch.setattr(convert, "shelf", None)
    begin(able=True)
    return begin


def test_a_mesh_is_made_once(later, tmp_path):
    meshes.keep_in(tmp_path)
    made = convert.mesh_object(TORUS, SCENE, 24)
    later()
    dark = TORUS.model_copy(update={"material": TORUS.material.model_copy(update={"color": (0.0, 0.0, 0.1)})})
    taken = convert.mesh_object(dark, SCENE, 24)
    assert taken is not made and set(vars(taken)) == set(vars(made)) and made.seconds > 0 and made.triangles > 1000
    for name, value in vars(made).items():
        assert np.array_equal(value, getattr(taken, name)) and type(value) is type(getattr(taken, name)), name
    assert taken.faces.dtype == made.faces.dtype and not taken.vertices.flags.writeable
    for other in ((TORUS, SCENE, 25), (TORUS.model_copy(update={"surface": TORUS.surface.model_copy(update={"r": 0.3})}), SCENE, 24)):
        with pytest.raises(AssertionError, match="made again"):
            convert.mesh_object(*other)


def test_a_file_that_is_not_whole_is_made_again(later, tmp_path):
    meshes.keep_in(tmp_path)
    made = convert.mesh_object(TORUS, SCENE, 24)
    (file,) = (tmp_path / meshes.FOLDER).glob("*.npz")
    for spoil in (lambda: file.write_bytes(file.read_bytes()[:-9]), file.unlink, lambda: file.with_suffix(".json").write_text("{}")):
        spoil()
        later(able=True)
        assert np.array_equal(convert.mesh_object(TORUS, SCENE, 24).vertices, made.vertices)
        later()
        assert np.array_equal(convert.mesh_object(TORUS, SCENE, 24).vertices, made.vertices)


def test_a_mesh_that_goes_while_it_is_taken_is_made_again(later, tmp_path, monkeypatch):
    """Another process may bound the folder between a look at a mesh and its reading."""
    meshes.keep_in(tmp_path)
    convert.mesh_object(TORUS, SCENE, 24)
    (file,) = (tmp_path / meshes.FOLDER).glob("*.npz")
    monkeypatch.setattr(meshes.store, "load", lambda path, load=meshes.store.load: (path.unlink(), load(path)))
    later(able=True)
    assert convert.mesh_object(TORUS, SCENE, 24).triangles > 1000 and file.exists()  # made, and kept again


def test_the_folder_has_a_size(later, tmp_path, monkeypatch):
    meshes.keep_in(tmp_path)
    for resolution in (24, 25, 26):
        if resolution == 26:
            size = sum(file.stat().st_size for file in (tmp_path / meshes.FOLDER).glob("*.npz"))
            monkeypatch.setattr(meshes, "MOST_BYTES", int(1.2 * size))  # of two of them
        convert.mesh_object(TORUS, SCENE, resolution)
    assert len(list((tmp_path / meshes.FOLDER).iterdir())) == 4
    later()
    for resolution in (25, 26):
        convert.mesh_object(TORUS, SCENE, resolution)
    with pytest.raises(AssertionError, match="made again"):
        convert.mesh_object(TORUS, SCENE, 24)


def test_renderers_in_processes_of_their_own_have_one_mesh(tmp_path):
    """And the picture that they make with it is the one they make without."""
    pytest.importorskip("embreex")
    settings, pictures = {"resolution": 24}, []
    for folder, names in ((tmp_path / "both", ("mitsuba-mesh", "embree")), (tmp_path / "alone", ("embree",))):
        store = RunStore(folder)
        with Pool(1) as pool:
            runs = [store.make(Request(SCENE, name, settings), pool, 300) for name in names]
        assert [run.state for run in runs] == ["ok"] * len(runs)
        assert len(list((folder / meshes.FOLDER).glob("*.npz"))) == 1
        pictures.append(store.planes(runs[-1], SCENE)["color"])
        seconds = [run.timing.build for run in runs]
    assert np.array_equal(*pictures) and min(seconds) > 0
