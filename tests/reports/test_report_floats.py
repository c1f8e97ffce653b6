"""The numbers beside a page: unpacked by the rule that the file states, they are the picture's to the last bit."""

import json
import re
import zlib
from dataclasses import replace

import numpy as np
import pytest
from report_support import HOSTILE, make_run

from raytruth.reports.figures import floats
from raytruth.reports.figures.planes import read


def unpacked_characters(plane: dict) -> bytes:
    bits = "".join(f"{ord(character) - 0x4000:015b}" for character in plane["data"])
    return int(bits[:8 * plane["bytes"]], 2).to_bytes(plane["bytes"], "big")


def unpacked(path, base=None) -> dict[str, np.ndarray]:
    """What the docstring of `floats` says, backwards."""
    text = path.read_text(encoding="utf-16")
    assert text.startswith("raytruth.planes(") and text.endswith(");\n")
    key, content = json.loads(f"[{text[len('raytruth.planes('):-3]}]")
    found = {"key": key, **content}
    height, width = found["height"], found["width"]
    for name, plane in found["planes"].items():
        kind, raw = np.dtype("<" + plane["type"]), zlib.decompress(unpacked_characters(plane))
        by_byte = np.frombuffer(raw, np.uint8).reshape(kind.itemsize, height, -1, width)
        whole = np.ascontiguousarray(by_byte.transpose(1, 3, 2, 0)).view(f"<u{kind.itemsize}")[..., 0]
        if plane["way"] != "plain":
            half = whole >> whole.dtype.type(1)
            whole = np.where(whole & whole.dtype.type(1), ~half, half)
        if plane["way"] == "near":
            whole = np.cumsum(np.cumsum(whole, axis=1, dtype=whole.dtype), axis=0, dtype=whole.dtype)
        elif plane["way"] == "base":
            whole = whole + np.where(np.isnan(base[name]), 0, base[name]).astype(kind).view(whole.dtype).reshape(whole.shape)
        found[name] = whole.view(kind).ravel()
    return found


@pytest.fixture
def sides(folder):
    return {name: read(make_run(name), folder) for name in ("good", "bad", "paper")}


def test_every_number_comes_back(sides, tmp_path):
    base = unpacked(tmp_path / floats.write("good", sides["good"], {}, None, tmp_path).file)
    for name in ("bad", "paper"):
        told = floats.write(name, sides[name], {"good": sides["good"]}, None, tmp_path)
        found = unpacked(tmp_path / told.file, base)
        assert found["base"] == "good" and told.bits == 64 and told.size == (tmp_path / told.file).stat().st_size
        for plane in ("color", "t", "index", "status"):
            assert np.array_equal(found[plane], getattr(sides[name], plane).ravel(), equal_nan=plane in ("color", "t"))
        assert np.array_equal(found["normal"], sides[name].normal.astype(np.float32).ravel(), equal_nan=True)


def test_another_base_gives_other_numbers(sides, tmp_path):
    told = floats.write("paper", sides["paper"], {"good": sides["good"]}, None, tmp_path)
    wrong = {name: array + 1 for name, array in unpacked(
        tmp_path / floats.write("good", sides["good"], {}, None, tmp_path).file).items() if isinstance(array, np.ndarray)}
    assert not np.array_equal(unpacked(tmp_path / told.file, wrong)["color"], sides["paper"].color.ravel())


def test_a_picture_close_to_the_truth_takes_less_room(sides, tmp_path):
    alone = floats.write("paper", sides["paper"], {}, None, tmp_path).size
    assert floats.write("paper", sides["paper"], {"good": sides["good"]}, None, tmp_path).size < 0.6 * alone


def test_a_side_is_written_against_the_nearest_of_those_known(sides, tmp_path):
    near = replace(sides["paper"], color=sides["paper"].color * (1 + 1e-9))
    told = floats.write("x", near, {"good": sides["good"], "paper": sides["paper"]}, None, tmp_path)
    assert told.base == "paper" and told.size < floats.write("x", near, {"good": sides["good"]}, None, tmp_path).size


def test_neighbours_tell_of_a_smooth_plane(sides, tmp_path):
    """A ramp has no second differences: all its numbers take less than one plain number in ten."""
    row, col = np.indices(sides["good"].shape)
    ramp = replace(sides["good"], t=1 + (row * 3 + col) / 1024)
    found = unpacked(tmp_path / floats.write("x", ramp, {}, None, tmp_path).file)
    assert found["planes"]["t"]["way"] == "near" and found["planes"]["t"]["bytes"] < ramp.t.nbytes / 10
    assert np.array_equal(found["t"], ramp.t.ravel())


def test_single_precision_is_kept_only_where_it_holds_every_value(sides, tmp_path):
    single = replace(sides["good"], color=sides["good"].color.astype(np.float32).astype(float))
    told = floats.write("x", single, {}, None, tmp_path)
    assert told.bits == 32 and np.array_equal(unpacked(tmp_path / told.file)["color"], single.color.ravel())
    single.color[0, 0, 0] = 0.1  # no number of 32 bits
    assert floats.write("x", single, {}, None, tmp_path).bits == 64


def test_limits_go_along_and_names_are_texts(sides, tmp_path):
    limit = np.full(sides["good"].shape, 0.25)
    limit[0, 0], limit[0, 1] = 1 / 3, np.inf
    told = floats.write(HOSTILE, sides["good"], {}, limit, tmp_path)
    found = unpacked(tmp_path / told.file)
    assert (found["limit"][2:] == 0.25).all() and found["key"] == HOSTILE
    assert np.float32(1 / 3) < found["limit"][0] < 1 / 3 * (1 + 2**-8) and found["limit"][1] == np.inf  # up, and by little
    assert re.fullmatch(r"planes/[a-z0-9-]+\.js", told.file)
