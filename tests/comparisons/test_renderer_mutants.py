"""The judge in front of renderers that are wrong on purpose, each in one way, and of others that are right in another way."""

import numpy as np
import pytest
from mutants import MUTANTS, SCENE, right

from raytruth.comparisons import renderers
from raytruth.comparisons.attribution.measure import attribute
from raytruth.comparisons.execution.store import Store
from raytruth.comparisons.results import OF_OBJECTS
from raytruth.comparisons.verdicts import conditioning, metrics
from raytruth.comparisons.verdicts.conditioning import Accuracy
from raytruth.comparisons.verdicts.judge import judge
from raytruth.comparisons.verdicts.metrics import largest_around
from raytruth.comparisons.verdicts.pictures import verdict_on
from raytruth.comparisons.verdicts.tolerances import MESH, NATIVE
from raytruth.reference_tracer.tracer.render import render
from raytruth.reference_tracer.tracer.sensitivity import ORIGIN_UNITS, UNIT, perturbed


@pytest.fixture(scope="module")
def kept(tmp_path_factory):
    return Store(tmp_path_factory.mktemp("results"), conditioning.FOLDER)


@pytest.mark.parametrize("name", MUTANTS)
def test_a_mutant_differs_and_its_stage_is_named(name, kept):
    mutant = MUTANTS[name]
    verdict, reason, _gates = verdict_on(SCENE, name, mutant.make(SCENE), right(SCENE), kept)
    assert verdict == "differs", reason
    if mutant.stage:
        found = attribute(SCENE, right, mutant.make)
        assert found.stage == mutant.stage, found.sentence


def test_there_are_enough_of_them():
    assert len(MUTANTS) >= 30 and sum(mutant.stage is not None for mutant in MUTANTS.values()) >= 28


def test_more_pixels_excused_than_rounding_explains_differ(kept):
    """Beside every silhouette each pixel might show what its neighbour shows; all together do not."""
    accuracy = Accuracy(32, (0.0, 0.01, 0.0, 0.0), (0.0,) * 4)
    limits = conditioning.limits(SCENE, accuracy, kept)
    planes = [{**vars(right(SCENE)), "camera": np.zeros(3)} for _ in range(2)]
    a, b = ({name: plane.copy() if isinstance(plane, np.ndarray) else plane for name, plane in p.items()} for p in planes)
    for axis in (0, 1):
        for way in (1, -1):
            edge = (a["index"] != np.roll(a["index"], way, axis)) & (largest_around(limits.risk) > 0)
            for name in ("color", "t", "position", "normal", "index", "depth"):
                b[name][edge] = np.roll(a[name], way, axis)[edge]
    found = {**metrics.geometry(a, b), **metrics.picture(a, b), **conditioning.apart(a, b, limits)}
    assert found["excused pixels"] > found["pixels at risk"] > 0
    gates = {gate.name: gate.holds for gate in judge(found, MESH, NATIVE)[2]}
    assert not gates["excused pixels"]


def test_normals_a_degree_off_differ_on_a_mesh_too(kept):
    """What is stated of a mesh's normals does not hide them: all that Embree states of its meshes of this scene, and of ones
    eight times as coarse."""
    for resolution in (256, 32):
        picture, stated = MUTANTS["normals of one object a degree off"].make(SCENE), renderers.render(
            "embree", SCENE, {"resolution": resolution}).metadata
        picture.metadata |= {name: stated[name] for name in (*OF_OBJECTS, "precision", "triangles")}
        assert max(stated["errors"]) > 0
        verdict, reason, _ = verdict_on(SCENE, "embree", picture, right(SCENE), kept)
        assert verdict == "differs", reason


def single(picture):
    picture.metadata["precision"] = 32
    return picture


def moved(precision, seed):
    """Rays by a unit of rounding in their origin, and half a one in their direction."""
    picture = perturbed(SCENE, "exact", UNIT[precision] / ORIGIN_UNITS, seed)[0]
    return single(picture) if precision == 32 else picture


FAULTLESS = {
    "the reference again": lambda: render(SCENE),
    "one thread": lambda: render(SCENE, threads=1),
    "interval arithmetic": lambda: render(SCENE, "interval"),
    "proofs": lambda: render(SCENE, "proof"),
    "Descartes' rule": lambda: render(SCENE, "descartes"),
    "rays a unit of rounding off": lambda: moved(64, 1001),
    "rays a unit of rounding off elsewhere": lambda: moved(64, 1002),
    "rays a unit of single precision off": lambda: moved(32, 1003),
    "rays a unit of single precision off elsewhere": lambda: moved(32, 1004),
    "single precision": lambda: single(render(SCENE, precision=32)),
    "Mitsuba's own shapes": lambda: renderers.render("mitsuba-native", SCENE),
    "meshes in Mitsuba": lambda: renderers.render("mitsuba-mesh", SCENE),
    "hits moved onto f": lambda: renderers.render("mitsuba-refined", SCENE),
    "meshes in Embree": lambda: renderers.render("embree", SCENE),
}


@pytest.mark.parametrize("name", FAULTLESS)
def test_a_faultless_renderer_agrees(name, kept):
    verdict, reason, _ = verdict_on(SCENE, name, FAULTLESS[name](), right(SCENE), kept)
    assert verdict == "agrees", reason
