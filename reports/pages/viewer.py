"""What the viewer of a scene's page is made from: its sides, the comparisons between them, and the scale of errors."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass

from raytruth.comparisons.results import Run, SceneRecord
from raytruth.comparisons.verdicts.metrics import APART, WORST

from ..cases import Case
from ..figures import scale
from ..figures.maps import object_colours
from ..figures.pictures import RunPictures
from ..figures.scale import css
from .page import Report


@dataclass(frozen=True)
class Side:
    """A picture that can be chosen."""

    id: str  # in links: the renderer's name, or the run's key where two have that
    run: Run
    pictures: RunPictures


@dataclass(frozen=True)
class Viewer:
    """A scene's sides, the truth first; `data` is what the script reads."""

    sides: list[Side]
    data: dict

    def id_of(self, run: Run) -> str | None:
        return next((side.id for side in self.sides if side.run.key == run.key), None)


def viewer(report: Report, scene: SceneRecord, root: str) -> Viewer | None:
    """None where fewer than two pictures can be shown. `root` leads from the page to the report's folder."""
    cases, pictures = report.of_scene(scene), report.pictures[scene.name].runs
    runs = {run.key: run for case in cases for run in (case.reference, case.test)
            if run.key in pictures and pictures[run.key].floats}
    truths = [case.reference.key for case in cases]
    ordered = sorted(runs.values(), key=lambda run: (run.key not in truths, run.renderer))
    if len(ordered) < 2:
        return None
    names = Counter(run.renderer for run in ordered)
    sides = [Side(run.renderer if names[run.renderer] == 1 else run.key, run, pictures[run.key]) for run in ordered]
    found = Viewer(sides, {})
    pairs = [_pair(case, found) for case in cases if case.reference.key in runs and case.test.key in runs]
    found.data.update({
        "scene": scene.name, "name": scene.name, "width": sides[0].pictures.width, "height": sides[0].pictures.height,
        "truth": sides[0].id, "pair": [pairs[0]["a"], pairs[0]["b"]] if pairs else [side.id for side in sides[:2]],
        "sides": [{"id": side.id, "title": side.run.title, "key": side.run.key, "command": side.run.command,
                   "file": root + numbers.file, "base": numbers.base, "bytes": numbers.size, "bits": numbers.bits}
                  for side in sides for numbers in [side.pictures.floats]],
        "pairs": pairs,
        "objects": [{"name": name, "rgb": colour.tolist()}
                    for name, colour in zip(scene.objects, object_colours(len(scene.objects)))],
        "scale": {"table": scale.TABLE.tolist(), "worst": WORST, "apart": APART,
                  "special": {"mismatch": scale.MISMATCH.tolist(), "undecided": scale.UNDECIDED.tolist(),
                              "non_finite": scale.NON_FINITE.tolist()}},
    })
    return found


def _pair(case: Case, found: Viewer) -> dict:
    return {"a": found.id_of(case.reference), "b": found.id_of(case.test), "anchor": case.anchor,
            "command": case.comparison.command, "histories": [
                {"row": pixel.row, "col": pixel.col, "anchor": case.history_anchor(pixel)} for pixel in case.histories]}


def objects(scene: SceneRecord) -> list[tuple[str, str, str]]:
    """Name, surface and colour of every object."""
    return list(zip(scene.objects, scene.surfaces, map(css, object_colours(len(scene.objects)))))
