"""What attributions say, as documents hold it."""

from __future__ import annotations

from typing import Literal

from pydantic import Field

from ..document import Record

Stage = Literal["camera", "hit", "root", "normal", "shading", "shadow", "reflection", "refraction", "mixing", "sampling"]
STAGES: tuple[Stage, ...] = ("camera", "hit", "root", "normal", "shading", "shadow", "reflection", "refraction",
                             "mixing", "sampling")
Outcome = Literal["agrees", "diverges", "not asked"]

FILE = "attribution.json"


class Evidence(Record):
    """What one stage was asked, and what came of it."""

    stage: Stage
    questions: list[str] = Field([], description="the derived scenes, in a few words; none where the scene has no such "
                                 "stage, or an earlier one diverged")
    outcome: Outcome
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
    """All rays of one pixel on one side."""

    renderer: str
    rays: list[Ray]
    note: str = Field("", description="what is missing, and why")


class WorstPixel(Record):
    """A pixel that diverges most, followed on both sides."""

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
    """What a child process finds."""

    found: bool | None = Field(description="whether the comparison of the pictures differs; None: not asked")
    reason: str = Field(description="the comparison's reason")
    attribution: Attribution


class Made(Record):
    """What became of a task; `judged` is there if `state` is "ok"."""

    state: Literal["ok", "crashed", "timeout", "malformed", "refused", "missing"]
    message: str = ""
    judged: Judged | None = None


class Judgement(Record):
    """What one renderer alone makes of a tracer that is wrong on purpose."""

    renderer: str
    title: str
    state: Literal["ok", "crashed", "timeout", "malformed", "refused", "missing"]
    message: str = ""
    found: bool | None = Field(None, description="whether the comparison with this renderer alone differs")
    reason: str = Field("", description="the comparison's reason")
    attribution: Attribution | None = None


class WrongOnPurpose(Record):
    """A fault put into the reference tracer, and who noticed."""

    id: str
    title: str
    effect: str = Field(description="the scene of one effect that it is shown on")
    right: str = Field(description="the passage of the source; empty for the tracer as it is")
    wrong: str = Field(description="what stands there instead")
    expected: Stage | None = Field(description="the stage that must be named")
    because: str
    judgements: list[Judgement]

    @property
    def holds(self) -> bool:
        """Whether every renderer that could judge found the fault and named its stage; none is found where none is."""
        asked = [j for j in self.judgements if j.state == "ok"]
        return bool(asked) and all(j.found == (self.expected is not None) and j.attribution.stage == self.expected
                                   for j in asked)


class Table(Record):
    """The document attribution.json."""

    version: Literal[1] = 1
    width: int
    height: int
    rows: list[WrongOnPurpose]
    command: str
