"""The picture files of a report: each run's pictures once; error maps, four a comparison, one an effect."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from comparisons.results import Run
from reference_tracer.tracer.image_files import to_8_bit, write_8_bit

from . import maps, scale
from .cases import Case
from .effects import Shown
from .names import slug
from .planes import NoPlanes, Planes, read
from .rings import Ring, around_marks, around_worst
from .spread import Spread, spread

RUNS, ERRORS, EFFECTS = "images/runs", "images/errors", "images/effects"
SCALE = "images/scale.png"


@dataclass(frozen=True)
class RunPictures:
    """Pictures of one run: kind (color, depth, normal, objects) to file, relative to the report.

    A run that only an effect shows has its colours alone.
    """

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
    effects: dict[str, Maps]  # id of the effect: its map of colours
    missing: dict[str, str]  # key of a run without pictures: why


def write_scale(report: Path) -> None:
    """Makes the folders, and the colour bar of every legend: one pixel a level."""
    for folder in (RUNS, ERRORS, EFFECTS):
        (report / folder).mkdir(parents=True)
    write_8_bit(scale.TABLE[None], report / SCALE)


def write_scene(cases: list[Case], effects: list[Shown], results: Path, report: Path) -> ScenePictures:
    """Writes the pictures of one scene's cases and effects below `report`, from the planes in `results`."""
    planes, missing = {}, {}
    compared = [r for case in cases for r in (case.reference, case.test)]
    for run in compared + [r for shown in effects for r in shown.runs]:
        if run.key in planes or run.key in missing:
            continue
        try:
            planes[run.key] = read(run, results)
        except NoPlanes as reason:
            missing[run.key] = str(reason)
    references = [planes[c.reference.key] for c in cases if c.reference.key in planes]
    span = maps.depth_range((references or list(planes.values()))[0]) if planes else (1.0, 1.0)
    objects = len(cases[0].scene.objects) if cases else 0
    whole = {run.key for run in compared}
    runs = {key: _write_run(key, p, span, objects, report, key in whole) for key, p in planes.items()}
    return ScenePictures(runs, {c.comparison.id: _write_case(c, planes, missing, report) for c in cases},
                         {s.effect.id: _write_effect(s, planes, missing, report) for s in effects}, missing)


def _write_run(key: str, planes: Planes, span: tuple[float, float], objects: int, report: Path,
               whole: bool) -> RunPictures:
    pictures = {"color": to_8_bit(planes.color)}
    if whole:
        pictures |= {"depth": maps.depth_picture(planes, span), "normal": maps.normal_picture(planes),
                     "objects": maps.object_picture(planes, objects)}
    files = {}
    for kind, pixels in pictures.items():
        files[kind] = f"{RUNS}/{slug(key)}-{kind}.png"
        write_8_bit(pixels, report / files[kind])
    height, width = planes.shape
    return RunPictures(files, width, height, span, int(planes.undecided.sum()))


def _write_case(case: Case, planes: dict[str, Planes], missing: dict[str, str], report: Path) -> Maps:
    problem = _problem(("reference side", case.reference), ("test side", case.test), planes, missing)
    if problem:
        return Maps({}, problem)
    test = planes[case.test.key]
    errors = maps.errors(planes[case.reference.key], test)
    rings = {"color": around_worst(case.comparison.worst, test.shape), "objects": around_marks(errors)}
    return Maps({kind: _write_map(error, errors, f"{ERRORS}/{case.anchor}-{kind}.png", report, rings.get(kind, ()))
                 for kind, error in errors.named().items()})


def _write_effect(shown: Shown, planes: dict[str, Planes], missing: dict[str, str], report: Path) -> Maps:
    sides = ("run with the decision", shown.baseline), ("run without it", shown.variant)
    problem = shown.missing or _problem(*sides, planes, missing)
    if problem:
        return Maps({}, problem)
    errors = maps.errors(planes[shown.baseline.key], planes[shown.variant.key])
    return Maps({"color": _write_map(errors.color, errors, f"{EFFECTS}/{shown.anchor}.png", report)})


def _write_map(error, errors: maps.Errors, file: str, report: Path, rings: tuple[Ring, ...] = ()) -> Map:
    write_8_bit(scale.paint(error, errors.mismatch, errors.undecided), report / file)
    return Map(file, spread(error, errors), rings)


def _problem(left: tuple[str, Run], right: tuple[str, Run], planes: dict[str, Planes], missing: dict[str, str]) -> str:
    """Why the two sides cannot be held against each other; empty if they can."""
    for side, run in (left, right):
        if run.key in missing:
            return f"No picture of the {side}: {run.message or missing[run.key]}"
    (h, w), (other_h, other_w) = planes[left[1].key].shape, planes[right[1].key].shape
    if (h, w) != (other_h, other_w):
        return f"The pictures differ in size: {w} × {h} pixels are held against {other_w} × {other_h}."
    return ""
