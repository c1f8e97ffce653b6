"""Where the time of a suite went: what each of its cases took when it last ran."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator
from pathlib import Path
from typing import Literal

from pydantic import Field

from . import document
from .document import Record

FILE = "times.json"
COMMAND = "raytruth compare"
MOST = 12  # rows told of a suite


class Suite(Record):
    name: str
    created: str
    seconds: float = Field(description="of wall, from its beginning to its end")
    cases: list[tuple[str, float]] = Field(description='"stage: scene", or a name alone, and its seconds of wall')


class Times(Record):
    version: Literal[1] = 1
    suites: list[Suite]


def keep(suite: Suite, folder: Path) -> None:
    """Replaces what the file in `folder` says of the suite of that name. Raises UnwritableError."""
    path, found = folder / FILE, Times(suites=[suite])
    document.write(document.joined(document.found(path, Times, COMMAND), found, {"suites": lambda s: s.name}), path)


def told(folder: Path) -> Iterator[str]:
    """Lines for a terminal: of each suite its stages, those that took longest first. Raises InputError."""
    for suite in document.read(folder / FILE, Times, COMMAND).suites:
        stages: dict[str, list[tuple[float, str]]] = defaultdict(list)
        for label, seconds in suite.cases:
            stage, _, what = label.partition(": ")
            stages[stage].append((seconds, what))
        together = sum(seconds for _, seconds in suite.cases)
        yield f"{suite.name}, {suite.created}: {suite.seconds:.0f} s; {len(suite.cases)} cases of {together:.0f} s together"
        spent = {stage: sum(seconds for seconds, _ in cases) for stage, cases in stages.items()}
        ordered = sorted(spent, key=lambda stage: -spent[stage])
        for stage in ordered[:MOST]:
            longest, what = max(stages[stage])
            yield (f"  {stage:<42} {len(stages[stage]):>4} {spent[stage]:>8.1f} s {spent[stage] / max(together, 1e-9):>5.0%}"
                   + (f"   longest {longest:.1f} s, {what}" if what else ""))
        if rest := ordered[MOST:]:
            yield f"  {f'{len(rest)} more':<42} {'':>4} {sum(spent[stage] for stage in rest):>8.1f} s"
