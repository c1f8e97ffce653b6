"""What every page is made from, and one page before it is written."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path, PurePosixPath

import numpy as np

from raytruth.comparisons.document import Record
from raytruth.comparisons.results import Results, SceneRecord

from ..cases import Absence, Case, ShownEffect, cases, effects, failed_runs
from ..figures.pictures import ScenePictures


@dataclass(frozen=True)
class Report:
    results: Results
    cases: list[Case]  # worst first
    absent: list[Absence]  # runs without a picture, worst first
    effects: list[ShownEffect]  # of decisions on a picture
    documents: dict[str, Record]  # name of the file: what else was measured; each may be missing
    pictures: dict[str, ScenePictures]  # name of the scene: its files; filled as they are written
    folder: Path  # of the results
    earlier: Results | None = None  # of the run that changes are told against
    to_come: int = 0  # comparisons that are still under way

    def of_scene(self, scene: SceneRecord) -> list[Case]:
        return [case for case in self.cases if case.scene.name == scene.name]

    def effects_of_scene(self, scene: SceneRecord) -> list[ShownEffect]:
        return [shown for shown in self.effects if shown.effect.scene == scene.name]

    def main_picture(self, scene: SceneRecord) -> str | None:
        """The file of the scene's picture: the model's truth if there is one, else any reference, else any run."""
        runs = self.pictures[scene.name].runs
        found = self.of_scene(scene)
        keys = ([c.reference.key for c in found if c.comparison.against == "model"]
                + [c.reference.key for c in found] + list(runs))
        return next((runs[key].file for key in keys if key in runs), None)


def arrange(results: Results, documents: dict[str, Record] | None = None, folder: Path = Path(),
            earlier: Results | None = None, to_come: int = 0) -> Report:
    """Everything but the pictures. Raises InputError if the document contradicts itself."""
    return Report(results, cases(results), failed_runs(results), effects(results), documents or {}, {}, folder,
                  earlier, to_come)


@dataclass(frozen=True)
class Summary:
    """What the first page says of another one."""

    title: str
    text: str  # what is shown there
    finding: str  # in one sentence, printed bold; "" where there is none
    link: str  # the words that lead there


@dataclass(frozen=True)
class Page:
    path: str  # of the file, relative to the report
    template: str
    content: dict = field(default_factory=dict)  # what the template sees besides `report`, `root`, `path` and `bar`
    nav: str = ""  # its name in the bars at the top of every page; "" keeps it out
    section: str = ""  # the entry of the upper bar that it belongs to
    summary: Summary | None = None  # only of a page in the bar
    pictures: dict[str, np.ndarray] = field(default_factory=dict)  # files beside it: path to (h, w, 3) uint8
    tables: dict[str, str] = field(default_factory=dict)  # files beside it: path to text

    @property
    def root(self) -> str:
        """The way from this page back to the report's folder."""
        return "../" * (len(PurePosixPath(self.path).parts) - 1)
