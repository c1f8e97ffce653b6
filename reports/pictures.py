"""The picture files of a report: each run's pictures once, and four error maps for each comparison."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from reference_tracer.image_files import to_8_bit, write_8_bit

from . import maps, scale
from .cases import Case
from .names import slug
from .planes import NoPlanes, Planes, read
from .rings import Ring, around_marks, around_worst
from .spread import Spread, spread

RUNS, ERRORS = "images/runs", "images/errors"
SCALE = "images/scale.png"


@dataclass(frozen=True)
class RunPictures:
    """Pictures of one run: kind (color, depth, normal, objects) to file, relative to the report."""

    files: dict[str, str]
    width: int
    height: int
    depth_range: tuple[float, float]
    undecided: int


@dataclass(frozen=True)
class Map:
    file: str
    spread: Spread
    rings: tuple[Ring, ...] = ()


@dataclass(frozen=True)
class Maps:
    """The error maps of one comparison; without any, `missing` says why."""

    maps: dict[str, Map]
    missing: str = ""


@dataclass(frozen=True)
class ScenePictures:
    runs: dict[str, RunPictures]  # key of the run: its pictures
    cases: dict[str, Maps]  # id of the comparison: its maps
    missing: dict[str, str]  # key of a run without pictures: why


def write_scale(report: Path) -> None:
    """Makes the folders, and the colour bar of every legend: one pixel a level."""
    for folder in (RUNS, ERRORS):
        (report / folder).mkdir(parents=True)
    write_8_bit(scale.TABLE[None], report / SCALE)


def write_scene(cases: list[Case], results: Path, report: Path) -> ScenePictures:
    """Writes the pictures of one scene's cases below `report`, from the planes in `results`."""
    planes, missing = {}, {}
    for run in [r for case in cases for r in (case.reference, case.test)]:
        if run.key in planes or run.key in missing:
            continue
        try:
            planes[run.key] = read(run, results)
        except NoPlanes as reason:
            missing[run.key] = str(reason)
    references = [planes[c.reference.key] for c in cases if c.reference.key in planes]
    span = maps.depth_range((references or list(planes.values()))[0]) if planes else (1.0, 1.0)
    objects = len(cases[0].scene.objects) if cases else 0
    runs = {key: _write_run(key, p, span, objects, report) for key, p in planes.items()}
    return ScenePictures(runs, {c.comparison.id: _write_case(c, planes, missing, report) for c in cases}, missing)


def _write_run(key: str, planes: Planes, span: tuple[float, float], objects: int, report: Path) -> RunPictures:
    pictures = {"color": to_8_bit(planes.color), "depth": maps.depth_picture(planes, span),
                "normal": maps.normal_picture(planes), "objects": maps.object_picture(planes, objects)}
    files = {}
    for kind, pixels in pictures.items():
        files[kind] = f"{RUNS}/{slug(key)}-{kind}.png"
        write_8_bit(pixels, report / files[kind])
    height, width = planes.shape
    return RunPictures(files, width, height, span, int(planes.undecided.sum()))


def _write_case(case: Case, planes: dict[str, Planes], missing: dict[str, str], report: Path) -> Maps:
    for side, run in (("reference", case.reference), ("test", case.test)):
        if run.key in missing:
            return Maps({}, f"No picture of the {side} side: {run.message or missing[run.key]}")
    reference, test = planes[case.reference.key], planes[case.test.key]
    if reference.shape != test.shape:
        (h, w), (test_h, test_w) = reference.shape, test.shape
        return Maps({}, f"The pictures differ in size: {w} × {h} pixels are held against {test_w} × {test_h}.")
    errors = maps.errors(reference, test)
    rings = {"color": around_worst(case.comparison.worst, test.shape), "objects": around_marks(errors)}
    written = {}
    for kind, error in errors.named().items():
        file = f"{ERRORS}/{case.anchor}-{kind}.png"
        write_8_bit(scale.paint(error, errors.mismatch, errors.undecided), report / file)
        written[kind] = Map(file, spread(error, errors), rings.get(kind, ()))
    return Maps(written)
