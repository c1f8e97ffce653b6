"""The ratios that were reached once: what falls below them has become slower."""

from __future__ import annotations

from pathlib import Path
from typing import Literal

from pydantic import Field

from .. import document
from ..document import Record
from ..results import Machine
from .results import Bench, Row

FILE = Path(__file__).with_name("accepted.json")
KEEPS = 0.85  # the share of an accepted ratio that a new one must reach; less is not explained by noise


class Reached(Record):
    """The medians of both clocks; `value` alone where a row is no time."""

    unit: str
    picture: str
    wall: float | None = None
    cpu: float | None = None
    value: float | None = None


class Accepted(Record):
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


def read(path: Path) -> Accepted:
    """Raises InputError where there is none."""
    return document.read(path, Accepted, "python -m comparisons.bench --accept")


def write(bench: Bench, earlier: Accepted | None, path: Path) -> Path:
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
