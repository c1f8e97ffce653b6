"""The files of a report's pictures: of each run its colours and its numbers; of each comparison and effect an error map."""

from __future__ import annotations

from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from raytruth.comparisons.execution.store import Store, UnwritableError
from raytruth.comparisons.results import Run
from raytruth.comparisons.verdicts import conditioning
from raytruth.comparisons.verdicts.pairs import accuracies
from raytruth.reference_tracer.tracer.image_files import to_8_bit

from ..cases import Case, ShownEffect
from ..text.words import slug
from . import floats, maps, png, scale
from .floats import FloatFile
from .maps import Ring, Spread, around_worst, spread
from .planes import NoPlanes, Planes, read

RUNS, ERRORS, EFFECTS, THUMBNAILS = "images/runs", "images/errors", "images/effects", "images/thumbnails"
THUMBNAIL = 160
SCALE = "images/scale.png"


@dataclass(frozen=True)
class RunPictures:
    """The picture of one run, relative to the report; its numbers if the viewer shows it."""

    file: str
    width: int
    height: int
    undecided: int
    floats: FloatFile | None = None


@dataclass(frozen=True)
class Map:
    file: str
    spread: Spread
    rings: tuple[Ring, ...] = ()


@dataclass(frozen=True)
class Maps:
    """The error map of one comparison or effect; without one, `missing` says why."""

    color: Map | None
    missing: str = ""


@dataclass(frozen=True)
class ScenePictures:
    runs: dict[str, RunPictures]  # key of the run: its pictures
    cases: dict[str, Maps]  # id of the comparison: its maps
    effects: dict[str, Maps]  # id of the effect: its map of colours
    missing: dict[str, str]  # key of a run without pictures: why
    thumbnail: str = ""  # of the truth's picture; "" where there is none


def write_scale(report: Path) -> None:
    """Makes the folders, and the colour bar of every legend: one pixel a level."""
    for folder in (RUNS, ERRORS, EFFECTS, THUMBNAILS):
        (report / folder).mkdir(parents=True)
    png.write(scale.TABLE[None], report / SCALE)


def write_scene(cases: list[Case], effects: list[ShownEffect], results: Path, report: Path) -> ScenePictures:
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
    runs = {key: _write_run(key, p, report) for key, p in planes.items()}
    truth = next((c.reference.key for c in cases if c.reference.key in planes), None)
    sides: dict[str, Planes] = {}  # each may be written against those before it; the truth is the first
    for case in cases:
        for run in (case.reference, case.test):
            if run.key in planes and run.key not in sides:
                limit = _limit(case, planes[run.key], results) if run is case.test else None
                runs[run.key] = replace(runs[run.key], floats=floats.write(run.key, planes[run.key], sides, limit, report))
                sides[run.key] = planes[run.key]
    return ScenePictures(runs, {c.comparison.id: _write_case(c, planes, missing, report) for c in cases},
                         {s.effect.id: _write_effect(s, planes, missing, report) for s in effects}, missing,
                         _write_thumbnail(truth, planes[truth], report) if truth else "")


def _write_thumbnail(key: str, planes: Planes, report: Path) -> str:
    """A picture of about THUMBNAIL pixels' width: the mean of squares of pixels."""
    height, width = planes.shape
    step = max(1, min(round(width / THUMBNAIL), height, width))
    cut = np.clip(np.nan_to_num(planes.color[:height // step * step, :width // step * step]), 0, 1)
    file = f"{THUMBNAILS}/{slug(key)}.png"
    png.write(to_8_bit(cut.reshape(height // step, step, width // step, step, 3).mean(axis=(1, 3))), report / file)
    return file


def _write_run(key: str, planes: Planes, report: Path) -> RunPictures:
    file = f"{RUNS}/{slug(key)}.png"
    png.write(to_8_bit(planes.color), report / file)
    height, width = planes.shape
    return RunPictures(file, width, height, int(planes.undecided.sum()))


def _limit(case: Case, planes: Planes, results: Path) -> np.ndarray | None:
    """How far each pixel's colour may be from the reference's, (h, w); None where that was not measured."""
    held = accuracies(case.reference, case.test)
    if not held or not (results / conditioning.FOLDER).is_dir():
        return None
    with suppress(UnwritableError, OSError, ValueError, KeyError):
        kept = Store(results, conditioning.FOLDER)
        found = [conditioning.kept_limits(case.scene.hash, accuracy, kept) for accuracy in held]
        if all(limits is not None and limits.color.shape == planes.shape for limits in found):
            return sum(limits.color for limits in found)
    return None


def _write_case(case: Case, planes: dict[str, Planes], missing: dict[str, str], report: Path) -> Maps:
    problem = _problem(("reference", case.reference), ("renderer under test", case.test), planes, missing)
    if problem:
        return Maps(None, problem)
    test = planes[case.test.key]
    errors = maps.errors(planes[case.reference.key], test)
    return Maps(_write_map(errors, f"{ERRORS}/{case.anchor}.png", report,
                           around_worst(case.comparison.worst, test.shape)))


def _write_effect(shown: ShownEffect, planes: dict[str, Planes], missing: dict[str, str], report: Path) -> Maps:
    problem = shown.missing or _problem(("run with the decision", shown.baseline), ("run without it", shown.variant),
                                        planes, missing)
    if problem:
        return Maps(None, problem)
    errors = maps.errors(planes[shown.baseline.key], planes[shown.variant.key])
    return Maps(_write_map(errors, f"{EFFECTS}/{shown.anchor}.png", report))


def _write_map(errors: maps.Errors, file: str, report: Path, rings: tuple[Ring, ...] = ()) -> Map:
    png.write(scale.paint(errors.color, errors.mismatch, errors.undecided), report / file)
    return Map(file, spread(errors.color, errors), rings)


def _problem(left: tuple[str, Run], right: tuple[str, Run], planes: dict[str, Planes], missing: dict[str, str]) -> str:
    """Why two runs cannot be held against each other; empty if they can."""
    for what, run in (left, right):
        if run.key in missing:
            return f"No picture of the {what}: {run.message or missing[run.key]}"
    (h, w), (other_h, other_w) = planes[left[1].key].shape, planes[right[1].key].shape
    if (h, w) != (other_h, other_w):
        return f"The pictures differ in size: {w} × {h} pixels are held against {other_w} × {other_h}."
    return ""
