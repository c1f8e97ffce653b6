"""Pictures of scenes that have not changed since the last report: a new one takes them over instead of making them again."""

from __future__ import annotations

import hashlib
import json
import re
import shutil
from pathlib import Path

from pydantic import TypeAdapter

from raytruth.comparisons.results import Run, SceneRecord

from .figures.pictures import ScenePictures
from .pages import Report

FILE = ".raytruth-pictures"  # in every report: name of each scene to what its pictures were made from, and which they are
NAME = re.compile(r'"((?:images/[a-z]+|planes)/[a-z0-9-]+\.(?:png|js))"')
AS_TEXT = TypeAdapter(ScenePictures)


def made_from(report: Report, scene: SceneRecord, results: Path, code: str) -> str:
    """A hash of all that can change the pictures of `scene`; `code` is one of what makes them."""
    cases, effects = report.of_scene(scene), report.effects_of_scene(scene)
    pairs = [*((case.reference, case.test) for case in cases), *(shown.runs for shown in effects)]
    runs = {run.key: run for pair in pairs for run in pair}.values()
    records = [*(case.comparison for case in cases), *(shown.effect for shown in effects), *runs]
    told = (code, *(record.model_dump_json() for record in records), *(size(run, results) for run in runs))
    return hashlib.sha256("\n".join(told).encode()).hexdigest()


def size(run: Run, results: Path) -> str:
    """Which planes a run has, and of what size; their names are hashes of what can change them."""
    path = results / (run.planes or "")
    return f"{run.planes} {path.stat().st_size if path.is_file() else None}\n"


def write(pictures: dict[str, ScenePictures], made_from: dict[str, str], report: Path) -> None:
    kept = {name: [made_from[name], AS_TEXT.dump_json(files).decode()] for name, files in pictures.items()}
    (report / FILE).write_text(json.dumps(kept), encoding="utf-8")


def read(report: Path) -> dict[str, tuple[str, str]]:
    try:
        return TypeAdapter(dict[str, tuple[str, str]]).validate_json((report / FILE).read_bytes())
    except (OSError, ValueError):
        return {}


def taken_over(kept: tuple[str, str] | None, made_from: str, earlier: Path, report: Path) -> ScenePictures | None:
    """The pictures of a scene, with their files put into `report`; None unless all of them were made from the same."""
    if kept is None or kept[0] != made_from:
        return None
    try:
        found = AS_TEXT.validate_json(kept[1])
        for name in set(NAME.findall(kept[1])):
            (report / name).parent.mkdir(exist_ok=True)
            shutil.copyfile(earlier / name, report / name)
        return found
    except (OSError, ValueError):
        return None
