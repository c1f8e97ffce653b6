"""The document: complete, repeatable, readable by the next program; and the command that makes it."""

import argparse
import json
import sys

import pytest

from raytruth.commands import stability
from raytruth.comparisons.execution import pool
from raytruth.comparisons.stability import cases as families
from raytruth.comparisons.stability import document as results
from raytruth.comparisons.stability import measure
from raytruth.comparisons.stability.cases import FAMILIES
from raytruth.comparisons.stability.methods import METHODS
from raytruth.reference_tracer.errors import InputError

FEW = ["grazing", "root-set", "secondary-rays", "printed-refraction", "undefined-gap"]
RAYS = 60


@pytest.fixture(scope="module")
def document(tmp_path_factory):
    return measure.run(families.find(FEW), tmp_path_factory.mktemp("results"), rays=RAYS)


def test_every_ray_is_counted(document):
    for family in document.families:
        assert len(family.labels) in (0, len(family.values))
        for series in family.series:
            values = family.values if series.precision == 64 else family.values_single
            assert len(series.points) == len(values)
            assert {p.rays for p in series.points} <= {RAYS, 0}


def test_every_method_runs_where_it_applies(document):
    """Closed forms on quadrics, Descartes on polynomials, the rest everywhere; the variants beside them."""
    ran = {f.id: {s.method for s in f.series} for f in document.families}
    every = {m.name for m in METHODS}
    assert ran["grazing"] == every and ran["undefined-gap"] == every - {"quadratic", "descartes"}
    assert ran["secondary-rays"] - every == {"paper, side from f(origin)", "paper, offset 0.01", "paper, offset 0.0001",
                                             "paper, offset 1e-06"}
    root_set = {s.method: [bool(p.counts) for p in s.points] for s in document.family("root-set").series}
    assert [k + 1 for k, ran in enumerate(root_set["descartes"]) if ran] == [4, 7, 8, 9]  # the polynomials of the table
    assert [k + 1 for k, ran in enumerate(root_set["quadratic"]) if ran] == [7]
    assert all(root_set["paper"]) and all(root_set["proof"])


def test_the_document_survives_a_file(document, tmp_path):
    results.keep(document, tmp_path)
    assert (tmp_path / "stability.json").exists() and not list(tmp_path.glob(".*.part*"))
    again = results.read(tmp_path)
    # compared as text: NaN, which examples may hold, is not equal to itself
    assert again.model_dump_json() == document.model_dump_json()
    assert again.family("grazing").laws[0].points == document.family("grazing").laws[0].points


def test_the_same_rays_every_time(document, tmp_path):
    """Alone or among others, a family gives the same counts: nothing hangs on the order of the generator's use."""
    alone = measure.run(families.find(["secondary-rays"]), tmp_path, rays=RAYS).family("secondary-rays")
    assert alone == document.family("secondary-rays")


def test_a_point_is_coloured_by_its_worst_kind():
    point = results.Point(counts={"correct": 390, "missed": 3, "diverged": 7})
    assert point.worst == "diverged" and point.rate("missed", "diverged") == 0.025
    assert results.Point(counts={"correct": 400}).worst == "correct"


@pytest.mark.parametrize("text, complaint", [
    (None, "cannot be read"), ("{", "not a stability document"), ("[]", "not a stability document"),
    ('{"version": 99}', "has version 99"), ('{"version": 1, "rays": "many"}', "make it again")])
def test_documents_that_are_none(tmp_path, text, complaint):
    if text is not None:
        (tmp_path / "stability.json").write_text(text)
    with pytest.raises(InputError, match=complaint) as caught:
        results.read(tmp_path)
    assert "\n" not in str(caught.value)


def test_the_whole_catalogue_is_there():
    """Every row of the catalogue of known failures and the whole-model cases, under names that never change."""
    assert {family.about.id for family in FAMILIES} == {
        "grazing", "near-miss", "small-ball", "asymptote", "camera-distance", "translated", "scaled-scene",
        "scaled-f", "thin-shell", "fine-steps", "never-zero", "even-root", "steep", "multiple-root", "horizon",
        "heart-belt", "heart-tips", "torus-axis", "pole", "domain-edge", "undefined-gap", "root-set",
        "secondary-rays", "critical-angle", "thin-medium", "normal-incidence", "printed-refraction", "slab-stack",
        "mirror-box", "depth-limit"}
    for family in FAMILIES:
        about = family.about
        assert all(text.endswith(".") for text in (about.when, about.why, about.instead)), about.id
        assert len(set(about.values)) == len(about.values)


# --- the command -----------------------------------------------------------------------------------------------------
def _run(*argv) -> int:
    parser = argparse.ArgumentParser()
    stability.add_arguments(parser)
    return stability.run(parser.parse_args(argv))


def test_the_command_tells_and_writes(tmp_path, capsys):
    """printed-refraction and horizon: no method claims anything wrong, the laws hold: exit code 0."""
    code = _run("--family", "printed-refraction", "--family", "horizon", "--rays", "60", "-o", str(tmp_path))
    lines = capsys.readouterr().out.splitlines()
    assert code == 0 and [f.id for f in results.read(tmp_path).families] == ["printed-refraction", "horizon"]
    row = next(line for line in lines if line.startswith("horizon"))
    assert "missed 100%" in row and row.count("ok") == 5 and row.endswith("hold")
    assert any(" ".join(line.split()) == "printed-refraction refraction as printed non-finite 100%" for line in lines)


def test_the_command_prints_json(capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert _run("--family", "horizon", "--rays", "60", "--json") == 0
    assert json.loads(capsys.readouterr().out)["families"][0]["id"] == "horizon"


WRONG_LAW = """
import dataclasses
from raytruth.comparisons.execution import worker
from raytruth.comparisons.execution import pool
from raytruth.comparisons.stability import cases as families
from raytruth.comparisons.stability.family import Law
family, = families.find(["horizon"])
families.find = lambda names: [dataclasses.replace(family, laws=(Law("paper", "never", lambda p: 0.0),))]
worker.main()
"""


@pytest.mark.parametrize("program, told", [
    (WRONG_LAW, "LAW BROKEN: horizon: paper"), ("import os; os.abort()", "NOT MEASURED: horizon: not measured: crashed")])
def test_findings_set_the_exit_code(capsys, monkeypatch, tmp_path, program, told):
    """A law that says the literal method never fails is broken by it; a crash is a finding: exit code 1, both are told."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(pool, "COMMAND", (sys.executable, "-c", program))
    assert _run("--family", "horizon", "--rays", "60") == 1
    assert told in capsys.readouterr().out


@pytest.mark.parametrize("argv, complaint", [(["--family", "cubes"], "no family is called 'cubes'"),
                                             (["--rays", "3"], "--rays: must be")])
def test_arguments_that_cannot_be_used(argv, complaint):
    with pytest.raises(InputError, match=complaint):
        _run(*argv)
