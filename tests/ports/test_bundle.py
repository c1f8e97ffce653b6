"""The bundle: its list of files, its checksums, and that others can read it with no more than JSON and raw arrays."""

import hashlib
import json
import struct
import subprocess
import zipfile
from pathlib import Path

import numpy as np
import pytest

from raytruth.cli import main
from raytruth.comparisons.ports import bundle, vectors
from raytruth.comparisons.ports.cases import Case
from raytruth.comparisons.ports.truth import Truths
from raytruth.reference_tracer.errors import InputError
from raytruth.reference_tracer.scene import library
from raytruth.reference_tracer.scene.load import load_scene

# an interface: a change of the list is a new version of the specification, and a new line here
FILES = {"1.0.0": (660, "3ebab71d96e2806d3e49703fcb082542ad98c816abfb4a81c35b5dc1fa3a55f2")}
GROUPS = ("surfaces/sphere", "events/recursion-1", "switches/ambient", "pictures/samples")


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """A bundle of two scenes and four groups, made as the whole one is."""
    folder = tmp_path_factory.mktemp("bundle")
    with pytest.MonkeyPatch.context() as patch:
        chosen = tuple(g for g in vectors.groups() if g.id in GROUPS)
        patch.setattr(vectors, "groups", lambda: chosen)
        patch.setattr(library, "names", lambda: ("figure-05-sphere",))
        patch.setattr(library, "effects", lambda: ("effect-mixing",))
        patch.setattr(bundle, "SIZE", (24, 18))
        archive = bundle.write(folder / "truth", Truths(folder / "results"))
        yield folder / "truth", archive


def test_the_list_of_files_is_that_of_its_version():
    names = bundle.files()
    assert len(set(names)) == len(names) and names == tuple(sorted(names))
    assert (len(names), hashlib.sha256("\n".join(names).encode()).hexdigest()) == FILES[bundle.SPECIFICATION]


def test_its_checksums_hold_and_find_what_is_changed(made):
    folder, _ = made
    check = lambda: subprocess.run(["sha256sum", "--quiet", "-c", "manifest-sha256.txt"], cwd=folder, capture_output=True)
    assert check().returncode == 0
    assert subprocess.run(["sha256sum", "--quiet", "-c", "tagmanifest-sha256.txt"], cwd=folder).returncode == 0
    listed = {line.split("  ", 1)[1].strip() for line in (folder / "manifest-sha256.txt").open()}
    assert listed == {p.relative_to(folder).as_posix() for p in (folder / "data").rglob("*") if p.is_file()}
    victim = folder / "data" / "versions.json"
    kept = victim.read_bytes()
    victim.write_bytes(kept + b" ")
    assert check().returncode == 1
    victim.write_bytes(kept)


def test_the_archive_is_the_folder_and_the_same_each_time(made, tmp_path):
    folder, archive = made
    with zipfile.ZipFile(archive) as file:
        assert {name.split("/", 1)[1] for name in file.namelist()} == {
            p.relative_to(folder).as_posix() for p in folder.rglob("*") if p.is_file()}
    first = archive.read_bytes()
    assert bundle._zipped(folder).read_bytes() == first


def test_planes_are_read_with_no_more_than_their_description(made):
    data = made[0] / "data"
    for where in data.glob("scenes/*/*/"):
        described = json.loads((where / "planes.json").read_text())
        for plane in described["planes"]:
            raw = (where / plane["file"]).read_bytes()
            array = np.frombuffer(raw, np.dtype(plane["dtype"]).newbyteorder("<"), offset=plane["offset"])
            assert array.size == np.prod(plane["shape"]), plane
    planes = json.loads((data / "scenes/figure-05-sphere/model/planes.json").read_text())["planes"]
    t, = (p for p in planes if p["name"] == "t")
    t = np.frombuffer((data / "scenes/figure-05-sphere/model" / t["file"]).read_bytes(), "<f8").reshape(t["shape"])
    # the ball of radius 1 at (0, 0, 3), looked at along z: nearest a little more than 2 away, beside the axis
    assert 2 < np.nanmin(t) < 2.01


def test_a_scene_of_the_bundle_is_a_scene(made):
    scene = load_scene(made[0] / "data/scenes/effect-mixing/scene.json")
    assert scene.hash == library.scene("effect-mixing").resized(24, 18).hash


def test_vectors_say_the_same_number_twice_and_follow_closed_forms(made):
    seen = set()
    for kind in bundle.KINDS:
        document = json.loads((made[0] / f"data/vectors/{kind}.json").read_text())
        assert set(document) >= set(bundle.vectors_schema()["required"])
        for group in document["groups"]:
            for vector in group.get("vectors", ()):
                seen.add(vector["id"])
                assert set(vector["flags"]) <= set(document["flags"])
                for level in vector["expected"].values():
                    for numbers in (vector["origin"], level["color"], level.get("t", vector["origin"])):
                        assert [struct.unpack(">d", bytes.fromhex(b))[0] for b in numbers["bits"]] == numbers["values"]
                    assert set(level["bounds"]) == {"fp64", "fp32"}
                    fp64, fp32 = level["bounds"]["fp64"]["color"], level["bounds"]["fp32"]["color"]
                    assert fp64 <= fp32 or level["bounds"]["fp64"]["rounding_decides"]
    assert "surfaces/sphere/25" in seen
    sphere, = (g for g in json.loads((made[0] / "data/vectors/surfaces.json").read_text())["groups"])
    axis, = (v for v in sphere["vectors"] if v["id"] == "surfaces/sphere/25")  # along z through the centre: z0 + 3 - r
    assert axis["expected"]["model"]["t"]["values"][0] == pytest.approx(4 + 3 - 1.2, abs=1e-14)
    assert axis["expected"]["model"]["normal"]["values"] == pytest.approx([0, 0, -1], abs=1e-14)


def test_both_truths_are_told_where_they_differ(made):
    sphere, = json.loads((made[0] / "data/vectors/surfaces.json").read_text())["groups"]
    thin = [v for v in sphere["vectors"] if "thin" in v["flags"]]
    assert thin and any(v["truths_differ"] for v in thin)  # a chord of 0.01 between steps of 0.1
    assert all(v["expected"]["model"]["index"] == 0 for v in thin)
    assert not any(v["truths_differ"] for v in sphere["vectors"] if v["flags"] == ["axis"])


def test_events_tell_all_rays_with_their_weights(made):
    mirrors, = json.loads((made[0] / "data/vectors/events.json").read_text())["groups"]
    for vector in mirrors["vectors"]:
        camera, mirrored = vector["expected"]["model"]["events"][:2]
        assert (camera["kind"], camera["weight"]) == ("camera", 1)
        assert (mirrored["kind"], mirrored["weight"]) == ("reflection", pytest.approx(0.8))


def test_the_command_refuses_what_it_cannot_write(capsys, tmp_path):
    (tmp_path / "full").mkdir()
    (tmp_path / "full" / "mine").write_text("")
    assert main(["truth", "-o", str(tmp_path / "full"), "--results", str(tmp_path)]) == 2
    assert "is not empty" in capsys.readouterr().err
    assert main(["truth"]) == 2 and "name the folder" in capsys.readouterr().err
    assert main(["truth", "--files"]) == 0 and "data/vectors/events.json" in capsys.readouterr().out


def test_a_bundle_without_its_specification_is_none(monkeypatch, tmp_path):
    monkeypatch.setattr(bundle, "DOCUMENTS", Path(tmp_path))
    with pytest.raises(InputError, match="run from a checkout"):
        bundle.write(tmp_path / "out", Truths(tmp_path / "results"))


def test_a_case_of_the_bundle_is_named_after_its_scene():
    assert all(Case(s.name, "model", s, "7").id == f"model:{s.name}" for s in bundle.scenes())
