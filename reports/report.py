"""What every page is made from."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from comparisons.document import Record
from comparisons.results import Results, Run, SceneRecord

from . import cases
from .cases import Case, Tally
from .chart import Chart, chart
from .decisions import Decision, read
from .effects import FIRST, Shown, effects
from .pictures import ScenePictures


@dataclass(frozen=True)
class Report:
    results: Results
    cases: list[Case]  # worst first
    failed: list[Run]  # runs without a picture, worst first
    tally: Tally
    charts: list[Chart]
    decisions: list[Decision]
    effects: list[Shown]  # of decisions on a picture
    documents: dict[str, Record]  # name of the file: what else was measured; each may be missing
    pictures: dict[str, ScenePictures]  # name of the scene: its files; filled as they are written
    folder: Path  # of the results

    def of_scene(self, scene: SceneRecord) -> list[Case]:
        return [case for case in self.cases if case.scene.name == scene.name]

    def effects_of_scene(self, scene: SceneRecord) -> list[Shown]:
        return [shown for shown in self.effects if shown.effect.scene == scene.name]

    @property
    def changing(self) -> set[str]:
        """Ids of the decisions that the page of effects speaks of."""
        return {FIRST} | {shown.effect.decision for shown in self.effects}

    def main_picture(self, scene: SceneRecord) -> str | None:
        """The file of the scene's picture: the model's truth if there is one, else any reference, else any run."""
        runs = self.pictures[scene.name].runs
        found = self.of_scene(scene)
        keys = ([c.reference.key for c in found if c.comparison.against == "model"]
                + [c.reference.key for c in found] + list(runs))
        return next((runs[key].files["color"] for key in keys if key in runs), None)


def arrange(results: Results, documents: dict[str, Record] | None = None, folder: Path = Path()) -> Report:
    """Everything but the pictures. Raises InputError if the document contradicts itself."""
    found, failed = cases.cases(results), cases.failed_runs(results)
    return Report(results, found, failed, cases.tally(found, failed), [chart(s) for s in results.series], read(),
                  effects(results), documents or {}, {}, folder)
