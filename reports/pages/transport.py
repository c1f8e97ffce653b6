"""The page of Mitsuba's own light transport: verdicts, pictures and error maps of every case."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import groupby
from pathlib import Path

import numpy as np

from raytruth.comparisons.transport.document import FILE, CaseRecord, read
from raytruth.reference_tracer.tracer.image_files import to_8_bit

from ..figures import scale
from ..figures.maps import Errors, color_error, spread
from ..figures.pictures import Map, RunPictures
from ..figures.planes import NoPlanes, load
from ..text.words import VERDICTS, Verdict, slug
from .page import Page, Report, Summary

__all__ = ["FILE", "pages", "read"]

FOLDER = "images/transport"
LEFT_OUT = np.array([96, 96, 96], np.uint8)  # where theory says nothing


@dataclass(frozen=True)
class ShownCase:
    """A case with its pictures; `missing` says why there are none, if so."""

    record: CaseRecord
    pictures: tuple[RunPictures, RunPictures] | None
    error: Map | None
    compared: float  # the share of pixels that theory speaks of
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


def pages(report: Report) -> list[Page]:
    document = report.documents.get(FILE)
    if document is None:
        return []
    cases = [_shown(record, report.folder) for record in document.cases]
    equal = [case for case in cases if case.record.kind == "equal"]
    findings = [case for case in cases if case.record.kind == "finding"]
    agree = sum(case.record.holds for case in equal)
    summary = Summary(
        "Mitsuba’s own light transport",
        f"{len(equal)} scenes, one effect each, that Mitsuba’s stock plugins must render as the document does, and "
        f"{len(findings)} that show where physics and the document differ.",
        f"{agree} of {len(equal)} agree." if agree < len(equal) else f"All {agree} agree.", "The light transport")
    return [Page("transport.html", "transport.html.j2", {
        "cases": cases,
        "effects": [(effect, list(group)) for effect, group in groupby(equal, key=lambda case: case.record.effect)],
        "findings": findings,
        "agree": agree,
        "equal": len(equal),
    }, nav="Light transport", summary=summary, pictures={file: p for case in cases for file, p in case.pixels.items()})]


def _shown(record: CaseRecord, folder: Path) -> ShownCase:
    if record.planes is None:
        return ShownCase(record, None, None, 0.0, f"No pictures: {record.message or record.state}", {})
    try:
        planes = load(record.planes, folder, {"document": 3, "mitsuba": 3, "expected": 3, "compared": 0})
    except NoPlanes as reason:
        return ShownCase(record, None, None, 0.0, str(reason), {})
    name = f"{FOLDER}/{slug(record.id)}"
    compared = planes["compared"].astype(bool)
    error = color_error(planes["expected"], planes["mitsuba"])
    painted = scale.paint(error, np.zeros_like(compared), np.zeros_like(compared))
    painted[~compared] = LEFT_OUT
    pixels = {f"{name}-{plane}.png": to_8_bit(planes[plane]) for plane in ("document", "mitsuba")}
    pictures = tuple(RunPictures(file, compared.shape[1], compared.shape[0], 0) for file in pixels)
    return ShownCase(record, pictures, Map(f"{name}-error.png", _spread(error[compared])), float(compared.mean()), "",
                     {**pixels, f"{name}-error.png": painted})


def _spread(error: np.ndarray):
    none = np.zeros(error.shape, bool)
    return spread(error, Errors(error, nothing=none, mismatch=none, undecided=none))
