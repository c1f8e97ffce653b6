"""The cases of Mitsuba's own light transport: verdicts, pictures and error maps."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from comparisons.verdicts.metrics import pixel_error
from comparisons.transport.results import CaseRecord, Transport
from reference_tracer.tracer.image_files import to_8_bit

from . import scale
from .maps import Errors
from .names import slug
from .pictures import Map, RunPictures
from .planes import NoPlanes, load
from .spread import spread
from .words import VERDICTS, Verdict

FOLDER = "images/transport"
LEFT_OUT = np.array([96, 96, 96], np.uint8)  # where theory says nothing


@dataclass(frozen=True)
class ShownCase:
    """A case with its pictures; `missing` says why there are none, if so."""

    record: CaseRecord
    sides: tuple[RunPictures, RunPictures] | None
    error: Map | None
    missing: str
    pixels: dict[str, np.ndarray]  # file to (h, w, 3) uint8

    @property
    def anchor(self) -> str:
        return slug(self.record.id)

    @property
    def verdict(self) -> Verdict:
        if self.record.state != "ok":
            return VERDICTS["not compared"]
        if not self.record.holds:
            return VERDICTS["differs"]
        return VERDICTS["expected" if self.record.kind == "finding" else "agrees"]


def shown(transport: Transport, folder: Path) -> list[ShownCase]:
    """Every case of the document, in its order; a case without pictures costs its own only."""
    return [_shown(record, folder) for record in transport.cases]


def _shown(record: CaseRecord, folder: Path) -> ShownCase:
    if record.planes is None:
        return ShownCase(record, None, None, f"No pictures: {record.message or record.state}", {})
    try:
        planes = _checked(load(record.planes, folder, ("document", "mitsuba", "expected", "compared")), record.planes)
    except NoPlanes as reason:
        return ShownCase(record, None, None, str(reason), {})
    name = f"{FOLDER}/{slug(record.id)}"
    compared = planes["compared"]
    error = pixel_error(planes["expected"], planes["mitsuba"])
    painted = scale.paint(error, np.zeros_like(compared), np.zeros_like(compared))
    painted[~compared] = LEFT_OUT
    pixels = {f"{name}-{side}.png": to_8_bit(planes[side]) for side in ("document", "mitsuba")}
    sides = tuple(RunPictures({"color": file}, compared.shape[1], compared.shape[0], (1.0, 1.0), 0) for file in pixels)
    return ShownCase(record, sides, Map(f"{name}-error.png", _spread(error[compared])), "",
                     {**pixels, f"{name}-error.png": painted})


def _spread(error: np.ndarray):
    none = np.zeros(error.shape, bool)
    return spread(error, Errors(error, error, error, error, nothing=none, mismatch=none, undecided=none))


def _checked(arrays: dict[str, np.ndarray], name: str) -> dict[str, np.ndarray]:
    size = arrays["compared"].shape
    if len(size) != 2 or 0 in size or arrays["compared"].dtype != bool:
        raise NoPlanes(f"{name} holds no pictures: plane compared has shape {size}.")
    for plane in ("document", "mitsuba", "expected"):
        if arrays[plane].shape != (*size, 3) or arrays[plane].dtype.kind != "f":
            raise NoPlanes(f"{name} holds no pictures: plane {plane} has shape {arrays[plane].shape}.")
    return arrays
