"""What the benchmark leaves behind, a row for every ratio: `bench.json`; and what is accepted, `accepted.json`."""

from __future__ import annotations

from pathlib import Path
from typing import Literal

from pydantic import Field

from .. import document
from ..document import Record
from ..results import Machine, State

FILE = "bench.json"
ACCEPTED = Path(__file__).with_name("accepted.json")
KEEPS = 0.85  # the share of an accepted ratio that a new one must reach; less is not explained by noise
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


class Reached(Record):
    """The medians of both clocks; `value` alone where a row is no time."""

    unit: str
    picture: str
    wall: float | None = None
    cpu: float | None = None
    value: float | None = None


class Accepted(Record):
    """The ratios that were reached once: what falls below them has become slower."""

    version: Literal[1] = 1
    created: str
    machine: Machine
    rows: dict[str, Reached] = Field(description="key of a row: what it reached")


class Fall(Record):
    """A row that lost more than it may."""

    key: str
    accepted: float
    now: float
    share: float = Field(description="how much of the accepted speed is left")


def read_accepted(path: Path) -> Accepted:
    """Raises InputError where there is none."""
    return document.read(path, Accepted, "raytruth bench --accept")


def accept(bench: Bench, earlier: Accepted | None, path: Path) -> Path:
    """Accepts the rows of `bench`; rows of `earlier` that were not measured now stay."""
    rows = dict(earlier.rows) if earlier else {}
    rows |= {row.key: _reached(row) for row in bench.rows if row.value is not None}
    return document.write(Accepted(created=bench.created, machine=bench.machine, rows=dict(sorted(rows.items()))), path)


def _reached(row: Row) -> Reached:
    return Reached(unit=row.unit, picture=row.picture, wall=row.wall and row.wall.median,
                   cpu=row.cpu and row.cpu.median, value=None if row.clock else row.value)


def falls(bench: Bench, accepted: Accepted) -> list[Fall]:
    """Rows that fell below their share of what was accepted.

    Only pictures of one size are compared, and seconds on the same processor only.
    """
    found = []
    for row in bench.rows:
        before = accepted.rows.get(row.key)
        if before is None or row.value is None or row.picture != before.picture:
            continue
        if row.unit == "s" and accepted.machine.processor != bench.machine.processor:
            continue
        then = getattr(before, row.clock or "value")
        if then and (share := _share(row, then)) < KEEPS:
            found.append(Fall(key=row.key, accepted=then, now=row.value, share=share))
    return found


def _share(row: Row, then: float) -> float:
    better, worse = (row.value, then) if row.sense == ">=" else (then, row.value)
    return better / worse if worse else 1.0
