"""Measures groups case by case in a process of their own: a crash costs the case it happened in."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import asdict

from ..execution.pool import Pool, Progress, Task
from ..suites import choose, head
from .cases import GROUPS, Group, Options
from .document import Bench, Row

LONGEST = 3600.0  # seconds for one case


def run(groups: Sequence[Group], options: Options, scenes: list[str], tell: Callable[[Row], None] = lambda row: None,
        progress: Progress | None = None) -> Bench:
    """The document of `groups`, of their cases named in `scenes` (all if empty); `tell` is called with every row."""
    start, rows, pairs = time.monotonic(), [], chosen(groups, scenes)
    with Pool(1, progress) as pool:
        for group, case in pairs:
            for row in _measured(pool, group, case, options):
                rows.append(row)
                tell(row)
    return Bench(**head(start), rows=rows)


def chosen(groups: Sequence[Group], scenes: list[str]) -> list[tuple[Group, str]]:
    """Pairs of group and case. Raises InputError for a scene that no group has."""
    pairs = [(group, case) for group in groups for case in group.cases]
    wanted = choose(scenes, {case: case for _, case in pairs}, "no case is called")
    return [(group, case) for group, case in pairs if case in wanted]


def _measured(pool: Pool, group: Group, case: str, options: Options) -> list[Row]:
    command = f"raytruth bench --only {group.name} --scenes {case}"
    found = pool.ask(Task(case, f"{group.name}: {case}", f"{__name__}:answer", {
        "group": group.name, "case": case, "options": asdict(options)}, LONGEST))
    if found["state"] == "ok":
        return [Row.model_validate({**row, "command": command}) for row in found["rows"]]
    return [Row(key=f"{group.name}/{case}", what=group.about, state=found["state"], message=found["message"],
                command=command)]


def answer(arguments: dict) -> dict:
    """In a worker: the rows of one case."""
    rows = GROUPS[arguments["group"]].measure(arguments["case"], Options(**arguments["options"]))
    return {"state": "ok", "rows": [row.model_dump(mode="json") for row in rows]}
