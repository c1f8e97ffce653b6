"""The document of the transport suite, `transport.json`: what a report needs to show every case.

`planes` names a .npz file beside the document with the arrays "document", "mitsuba" and "expected" ((h, w, 3), linear:
the document's picture, Mitsuba's, and what theory predicts of it) and "compared" ((h, w) bool, where it says so).
"""

from __future__ import annotations

from pathlib import Path
from typing import Literal

from pydantic import Field

from .. import document
from ..document import Record
from ..results import Gate, Machine, State

Effect = Literal["shading", "shadow", "reflection", "refraction", "total reflection", "mixing", "multisampling"]
FILE = "transport.json"
FOLDER = "transport"
COMMAND = "raytruth transport"


class CaseRecord(Record):
    """One case and what became of it."""

    id: str
    title: str
    effect: Effect
    kind: Literal["equal", "finding"] = Field(
        description="equal: theory says that both pictures are; finding: physics and the document differ, and theory "
                    "says how")
    because: str = Field(description="one sentence: why theory says so")
    judged: Literal["deterministic", "Monte Carlo"]
    samples: list[int] = Field([], description="of Monte Carlo: samples a pixel, rising")
    width: int
    height: int
    key: str = Field(description="hash of everything that can change the case")
    state: State
    message: str = Field("", description="what went wrong, in one line")
    holds: bool = Field(description="whether every gate holds; a case that was not measured does not hold")
    reason: str = Field(description="one sentence: what was found, with its numbers")
    gates: list[Gate] = []
    metrics: dict[str, float | int] = {}
    planes: str | None = None
    seconds: float | None = None
    command: str


class Transport(Record):
    """The whole document."""

    version: Literal[1] = 1
    created: str
    seconds: float
    machine: Machine
    cases: list[CaseRecord]

    @property
    def failed(self) -> list[CaseRecord]:
        """Cases that differ or were not measured; a missing program is no fault."""
        return [c for c in self.cases if not c.holds and c.state not in ("missing", "refused")]


def keep(transport: Transport, folder: Path, fresh: bool = False) -> Transport:
    """Writes the document into `folder`, with the other cases that are there unless `fresh`."""
    earlier = None if fresh else document.found(folder / FILE, Transport, COMMAND)
    return document.keep(document.joined(earlier, transport, {"cases": lambda c: c.id}), folder / FILE, COMMAND)


def read(folder: str | Path) -> Transport:
    """The document in `folder`. Raises InputError in one line."""
    return document.read(Path(folder) / FILE, Transport, COMMAND)
