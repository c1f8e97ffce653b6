"""A small results folder: real renders, and everything that can go wrong."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from report_support import ERROR_AT, HEIGHT, MISMATCH_AT, NAN_AT, UNDECIDED_AT, WIDTH, make_folder

from raytruth.reference_tracer.scene import library
from raytruth.reference_tracer.tracer.render import UNDECIDED, Picture, render


@pytest.fixture(scope="session")
def pictures() -> dict[str, Picture]:
    """`good` is the sphere; `bad` is the same with known faults at known pixels, all of them on the sphere."""
    scene = library.scene("figure-05-sphere").resized(WIDTH, HEIGHT, samples=1)
    good = render(scene, "exact")
    bad = replace(good, **{name: getattr(good, name).copy() for name in ("color", "index", "status")})
    for place, error in ERROR_AT.items():
        bad.color[place][1] += error
    bad.color[NAN_AT][2] = np.nan
    bad.status[UNDECIDED_AT] = UNDECIDED
    bad.index[MISMATCH_AT] = 5
    return {"good": good, "bad": bad, "paper": render(scene, "paper")}


@pytest.fixture
def folder(tmp_path, pictures) -> Path:
    """A results folder with an agreeing, a differing and an expected case, a crash, a refusal and a missing file."""
    return make_folder(tmp_path / "results", pictures)
