"""The results document: one versioned JSON file that says everything a report shows, beside the runs' image planes.

`results.json` and the folder `runs/` beside it are the whole interface between the comparisons and the reports.
"""

from __future__ import annotations

from pathlib import Path
from typing import Literal

from pydantic import Field

from . import document
from .attribution.document import Attribution
from .document import Record
from .execution.machine import Machine

VERSION = 1
FILE = "results.json"
COMMAND = "raytruth compare"
RUNS = "runs"

State = Literal["ok", "crashed", "timeout", "malformed", "refused", "missing"]
BROKEN = ("crashed", "timeout", "malformed")  # faults; "refused" and "missing" are answers
Verdict = Literal["agrees", "differs", "expected", "not compared"]


class SceneRecord(Record):
    """A scene as it was compared, at the size it was compared at."""

    name: str
    title: str
    figure: str
    description: str
    estimates: str
    hash: str
    width: int
    height: int
    samples: int
    objects: list[str] = Field(description="a name for every object, in scene order")
    surfaces: list[str] = Field(description="the kind of surface of every object")


class Timing(Record):
    """Seconds; None where a renderer has no such phase."""

    build: float | None = Field(None, description="converting the scene: meshing, acceleration structures")
    first: float | None = Field(None, description="the first picture, compilation included")
    warm: float | None = Field(None, description="the same picture once more, everything compiled")


class Run(Record):
    """One renderer's picture of one scene."""

    key: str = Field(description="hash of everything that can change the run; names its files")
    scene: str
    renderer: str
    title: str = Field(description="the renderer in words")
    settings: dict[str, float | int | str | bool] = {}
    state: State
    message: str = Field("", description="what went wrong, in one line")
    planes: str | None = Field(None, description="the .npz file of the picture's planes, relative to the results")
    timing: Timing = Timing()
    facts: dict[str, float | int | str | bool | None] = Field(
        {}, description="what else is worth telling: rays, undecided pixels, triangles, ...")
    errors: list[float | None] = Field([], description="for every object how far its surface lies from where it should, at "
                                                        "most; None: not measurable; no list: every object is exact")
    tilts: list[float] = Field([], description="for every object how far its facets turn from the surface, in radians")
    command: str = Field(description="the command that makes this picture again")


class Gate(Record):
    """One measured number against its limit."""

    name: str
    value: float | None
    limit: float
    holds: bool
    unit: str = ""
    means: str = Field(description="what the number is, in one sentence")


class Comparison(Record):
    """One picture against the reference's."""

    id: str
    scene: str
    reference: str = Field(description="key of the reference's run")
    test: str = Field(description="key of the run under test")
    against: Literal["algorithm", "model"] = Field(description="which of the two truths the reference run stands for")
    verdict: Verdict
    reason: str = Field(description="one sentence: why this verdict")
    instead: str = Field("", description="what of the scene is otherwise in both pictures, because the renderer cannot express "
                                         "it; empty: nothing")
    gates: list[Gate] = []
    metrics: dict[str, float | int | None] = Field({}, description="every number measured, gated or not")
    worst: list[dict[str, float | int]] = Field([], description="the pixels of largest error: row, col, error")
    attribution: Attribution | None = Field(None, description="where the two part first, if they differ")
    command: str


class Series(Record):
    """A study: one number measured over a sweep of one parameter."""

    id: str
    title: str
    x_label: str
    y_label: str
    lines: dict[str, list[tuple[float, float]]] = Field(description="label: points (x, y)")
    expected: str = Field(description="what theory says the curve does, and whether it did")
    slope: dict[str, float] = Field({}, description="measured slope of each line in log-log")
    holds: bool
    command: str


class Effect(Record):
    """What one decision changes in a picture: the same scene with it, and with what it rules out or limits."""

    id: str
    decision: str = Field(description="id of a row of DECISIONS.md")
    scene: str
    change: str = Field(description="what the variant does instead, in a few words")
    finding: str = Field(description="one sentence: what happens, with its numbers")
    baseline: str = Field(description="key of the run with the decision")
    variant: str = Field(description="key of the run without it")
    metrics: dict[str, float | int | None] = {}


class Results(Record):
    """Everything a report is made of."""

    version: Literal[1] = VERSION
    created: str
    seconds: float
    machine: Machine
    scenes: list[SceneRecord]
    runs: list[Run]
    comparisons: list[Comparison]
    series: list[Series] = []
    effects: list[Effect] = []

    def run(self, key: str) -> Run:
        return next(r for r in self.runs if r.key == key)


def write(results: Results, folder: Path) -> Path:
    return document.write(results, folder / FILE)


def joined(earlier: Results | None, results: Results) -> Results:
    """`results` with what an earlier document says of other scenes; lines of a study are joined in the same way."""
    scenes = {scene.name for scene in results.scenes}
    about = {"scenes": lambda s: s.name, **dict.fromkeys(("runs", "comparisons", "effects"), lambda row: row.scene)}
    found = document.joined(earlier, results, about, scenes)
    return document.joined(earlier, found.model_copy(update={"series": [
        _longer(old, new) for new in results.series
        for old in [next((s for s in (earlier.series if earlier else ()) if s.id == new.id), None)]]}),
        {"series": lambda s: s.id})


def _longer(old: Series | None, new: Series) -> Series:
    if old is None or not set(old.lines) - set(new.lines):
        return new
    return new.model_copy(update={"lines": {**old.lines, **new.lines}, "slope": {**old.slope, **new.slope},
                                  "holds": old.holds and new.holds})


def read(folder: str | Path) -> Results:
    """The results in `folder`. Raises InputError in one line."""
    return document.read(Path(folder) / FILE, Results, COMMAND)
