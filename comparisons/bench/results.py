"""What the benchmark leaves behind: one row for every ratio, bench.json."""

from __future__ import annotations

from typing import Literal

from pydantic import Field

from ..document import Record
from ..results import Machine, State

FILE = "bench.json"
Clock = Literal["wall", "cpu"]


class Spread(Record):
    """A number that was measured several times."""

    median: float
    low: float
    high: float


class Seconds(Record):
    """The median times of one contestant."""

    wall: float
    cpu: float = Field(description="of all its threads together")
    first: float | None = Field(None, description="wall time of the run before the turns, in which kernels compile")


class Row(Record):
    """One bar and what was measured against it."""

    key: str = Field(description="group, case and, where a case has several rows, which of them")
    what: str = Field(description="what is divided by what")
    unit: Literal["x", "s", "GiB"] = "x"
    bar: float | None = Field(None, description="None: only for information")
    sense: Literal[">=", "<="] = ">="
    clock: Clock | None = Field(None, description="the clock that decides; None where the value is no time")
    wall: Spread | None = None
    cpu: Spread | None = None
    value: float | None = Field(None, description="by which the row is judged: the median of the deciding clock")
    holds: bool | None = None
    turns: int = 0
    others: float | None = Field(None, description="cores that other programs of the machine kept busy meanwhile")
    seconds: dict[str, Seconds] = {}
    picture: str = Field("", description="size of the pictures: ratios of other sizes are other ratios")
    note: str = ""
    state: State = "ok"
    message: str = ""
    command: str = ""


class Bench(Record):
    """Everything that was measured in one run."""

    version: Literal[1] = 1
    created: str
    seconds: float
    machine: Machine
    rows: list[Row]
