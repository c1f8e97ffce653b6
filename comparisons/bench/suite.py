"""Runs groups case by case in a process of their own: a crash costs the case it happened in."""

from __future__ import annotations

import time
from collections.abc import Iterator
from dataclasses import asdict
from datetime import UTC, datetime

from reference_tracer.errors import InputError

from ..execution.machine import machine
from ..execution.pool import Pool, Task
from .groups import GROUPS
from .options import Options
from .results import Bench, Row

LONGEST = 3600.0  # seconds for one case


def run(groups: list, options: Options, scenes: list[str], tell=lambda row: None) -> Bench:
    """The document of `groups`, of their cases named in `scenes` (all if empty); `tell` is called with every row."""
    start, rows = time.monotonic(), []
    with Pool(1) as pool:
        for group, case in chosen(groups, scenes):
            for row in _measured(pool, group, case, options):
                rows.append(row)
                tell(row)
    return Bench(created=datetime.now(UTC).isoformat(timespec="seconds"), seconds=round(time.monotonic() - start, 1),
                 machine=machine(), rows=rows)


def answer(arguments: dict) -> dict:
    """In a worker: the rows of one case."""
    rows = GROUPS[arguments["group"]].measure(arguments["case"], Options(**arguments["options"]))
    return {"state": "ok", "rows": [row.model_dump(mode="json") for row in rows]}


def chosen(groups: list, scenes: list[str]) -> list[tuple]:
    """Pairs of group and case. Raises InputError for a scene that no group has."""
    pairs = [(group, case) for group in groups for case in group.CASES]
    known = {case for _, case in pairs}
    for scene in scenes:
        if scene not in known:
            raise InputError(f"no case is called {scene!r}; there are {', '.join(sorted(known))}")
    return [(group, case) for group, case in pairs if not scenes or case in scenes]


def _measured(pool: Pool, group, case: str, options: Options) -> Iterator[Row]:
    command = f"python -m comparisons.bench --only {group.NAME} --scenes {case}"
    answer = pool.ask(Task(case, f"{group.NAME}: {case}", "comparisons.bench.suite:answer", {
        "group": group.NAME, "case": case, "options": asdict(options)}, LONGEST))
    if answer["state"] == "ok":
        for row in answer["rows"]:
            yield Row.model_validate({**row, "command": command})
    else:
        yield Row(key=f"{group.NAME}/{case}", what=group.__doc__.strip().splitlines()[0], state=answer["state"],
                  message=answer["message"], command=command)
