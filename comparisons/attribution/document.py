"""What attributions say; the document of faults made on purpose, `attribution.json`."""

from __future__ import annotations

from pathlib import Path
from typing import Literal

from pydantic import Field

from .. import document
from ..document import Record

Stage = Literal["camera", "hit", "root", "normal", "shading", "shadow", "reflection", "refraction", "mixing", "sampling"]
STAGES: tuple[Stage, ...] = Stage.__args__
State = Literal["ok", "crashed", "timeout", "malformed", "refused", "missing"]

FILE = "attribution.json"
COMMAND = "raytruth attribute --wrong-on-purpose"


class Evidence(Record):
    """What one stage was asked, and what came of it."""

    stage: Stage
    questions: list[str] = Field([], description="the derived scenes, in a few words; none where the scene has no such "
                                 "stage, or an earlier one diverged")
    outcome: Literal["agrees", "diverges", "not asked"]
    pixels: int = Field(0, description="pixels that could be judged")
    diverging: int = Field(0, description="those apart by more than their bound, and by nothing an earlier stage explains")
    largest: float | None = Field(None, description="the largest difference among the diverging pixels")
    unit: str = Field("", description="what `largest` is measured in")


class Ray(Record):
    """One ray of a pixel, as the renderer traced it."""

    generation: int
    kind: Literal["camera", "reflection", "refraction"]
    object: str | None = Field(None, description="what it hit; None: nothing")
    t: float | None = None
    point: tuple[float, float, float] | None = None
    normal: tuple[float, float, float] | None = Field(None, description="turned against the ray")
    lights: int | None = Field(None, description="how many lights reach the point; None: the renderer does not tell")
    weight: float | None = Field(None, description="the ray's share in the pixel's colour")
    color: tuple[float, float, float] | None = Field(None, description="of the ray alone, without its descendants")


class History(Record):
    """All rays of one pixel in one renderer."""

    renderer: str
    rays: list[Ray]
    note: str = Field("", description="what is missing, and why")


class WorstPixel(Record):
    """A pixel that diverges most, followed through both renderers."""

    row: int
    col: int
    difference: float
    color_a: tuple[float, float, float]
    color_b: tuple[float, float, float]
    a: History
    b: History


class Attribution(Record):
    """The first stage at which two renderers part on a scene; None where they never do."""

    scene: str
    a: str = Field(description="the renderers, in words")
    b: str
    width: int
    height: int
    stage: Stage | None
    sentence: str
    evidence: list[Evidence]
    shown_on: str = Field("", description="the derived scene that the pixels below are of")
    pixels: list[WorstPixel] = []


class Judged(Record):
    """What a worker finds."""

    found: bool | None = Field(description="whether the comparison of the pictures differs; None: not asked")
    reason: str = Field(description="the comparison's reason")
    attribution: Attribution


class Answer(Record):
    """What became of a task; `judged` is there if `state` is "ok"."""

    state: State
    message: str = ""
    judged: Judged | None = None


class Judgement(Record):
    """What one renderer alone makes of a tracer that is wrong on purpose."""

    renderer: str
    title: str
    state: State
    message: str = ""
    found: bool | None = Field(None, description="whether the comparison with this renderer alone differs")
    reason: str = Field("", description="the comparison's reason")
    attribution: Attribution | None = None


class WrongOnPurpose(Record):
    """A fault put into the reference tracer, and who noticed."""

    id: str
    title: str
    effect: str = Field(description="the scene of one effect that it is shown on")
    right: str = Field(description="the formula; empty for the tracer as it is")
    wrong: str = Field(description="what is computed instead")
    expected: Stage | None = Field(description="the stage that must be named")
    because: str
    judgements: list[Judgement]

    @property
    def holds(self) -> bool:
        """Whether every renderer that could judge found the fault and named its stage; none is found where none is."""
        able = [j for j in self.judgements if j.state == "ok"]
        return bool(able) and all(j.found == (self.expected is not None) and j.attribution.stage == self.expected
                                  for j in able)


class Table(Record):
    """The document attribution.json."""

    version: Literal[1] = 1
    width: int
    height: int
    rows: list[WrongOnPurpose]
    command: str


def read(folder: Path) -> Table:
    """The table in `folder`. Raises InputError in one line."""
    return document.read(folder / FILE, Table, COMMAND)
