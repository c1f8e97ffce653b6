"""What planning leaves behind: for every scene the decisions with their evidence, the proof, and what was saved."""

from __future__ import annotations

from datetime import UTC, datetime
from pathlib import Path
from typing import Literal

from pydantic import Field

from .. import document
from ..bench.document import Clock, Seconds, Spread
from ..document import Record
from ..execution.machine import machine
from ..results import Machine, State

FILE = "plan.json"
PLANES = "plans"
COMMAND = "raytruth plan"


class Trial(Record):
    """One value that was tried for a parameter, the decisions before it in force."""

    value: str
    change: float = Field(description="largest change of any channel of a pixel of the deciding half against the truth")
    holds: bool = Field(description="whether that leaves enough of the tolerance")


class DecisionRecord(Record):
    """What was decided about one parameter."""

    parameter: str
    written: str = Field(description="its value in the scene as written")
    planned: str
    changed: bool
    withdrawn: bool = Field(False, description="taken back because all decisions together exceeded the tolerance")
    evidence: str = Field(description="why, in a few words with their numbers")
    trials: list[Trial] = []


class Proof(Record):
    """The planned scene against the scene as written with exact intersections, on a sample: pixels that decided nothing."""

    pixels: int = Field(description="of the whole picture")
    held_back: int = Field(description="pixels that were not used to decide anything")
    largest: float = Field(description="largest difference of any channel of a held-back pixel that is not excused")
    excused: int = Field(description="held-back pixels over the tolerance that rounding alone may change as much")
    excused_largest: float = 0.0
    most_excused: int = Field(description="how many may be excused")
    holds: bool


class Ratio(Record):
    """How many times longer the scene as written takes than the planned one, turn by turn."""

    wall: Spread
    cpu: Spread
    clock: Clock = Field(description="the one that counts: wall on a quiet machine, else processor time")

    @property
    def spread(self) -> Spread:
        return self.wall if self.clock == "wall" else self.cpu

    @property
    def value(self) -> float:
        return self.spread.median


class Saved(Record):
    """What the plan saves, all kernels compiled before."""

    exact: Ratio = Field(description="colours of scenes made ready; as written with exact intersections")
    paper: Ratio = Field(description="the same; as written with the document's own method")
    call: Ratio = Field(description="a whole call of render, all planes; as written with exact intersections")
    turns: int
    others: float = Field(description="cores that other programs of the machine kept busy meanwhile")
    seconds: dict[str, Seconds]
    rays_written: int = Field(description="camera and secondary rays, with those that pad queues")
    rays_planned: int


class MeshTrial(Record):
    """Mitsuba on meshes of one resolution, against the same truth on the same held-back pixels."""

    resolution: int
    state: State
    message: str = ""
    over: int | None = Field(None, description="pixels over the tolerance that rounding does not excuse")
    largest: float | None = None
    build: float | None = Field(None, description="seconds to make the meshes")
    warm: float | None = Field(None, description="seconds to trace them, everything compiled")


class Plan(Record):
    """The plan for one scene."""

    scene: str
    title: str
    figure: str
    hash: str
    width: int
    height: int
    samples: int
    tolerance: float
    margin: float = Field(description="share of the tolerance that the decisions were allowed to use")
    attempts: int = Field(description="plans made; all but the last failed their proof")
    seconds: float = Field(description="spent on finding and proving, compilation included")
    cpu_seconds: float = Field(description="the same, of all threads together")
    decisions: list[DecisionRecord]
    proof: Proof
    saved: Saved
    meshes: list[MeshTrial] = []
    planned: dict = Field(description="the planned scene, as a scene file says it")
    planes: str = Field("", description="the .npz file, relative to the results: color, the planned picture in 8 bits "
                                        "a channel, and change, the largest difference of a channel of every pixel")
    command: str


class Planning(Record):
    """What became of planning a scene; `plan` is there if `state` is "ok"."""

    state: State = "ok"
    message: str = ""
    plan: Plan | None = None


class Plans(Record):
    """The plans of several scenes."""

    version: Literal[1] = 1
    created: str
    machine: Machine
    plans: list[Plan]


def read(folder: Path) -> Plans:
    """The plans in `folder`. Raises InputError in one line."""
    return document.read(folder / FILE, Plans, COMMAND)


def document_of(plans: list[Plan]) -> Plans:
    return Plans(created=datetime.now(UTC).isoformat(timespec="seconds"), machine=machine(), plans=plans)


def add(plan: Plan, folder: Path) -> None:
    """Puts `plan` among those in `folder`, in place of an earlier one of the same scene.

    Raises InputError if the folder holds plans that cannot be read.
    """
    others = [p for p in read(folder).plans if p.scene != plan.scene] if (folder / FILE).exists() else []
    document.keep(document_of(sorted([*others, plan], key=lambda p: p.scene)), folder / FILE, COMMAND)
