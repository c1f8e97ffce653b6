"""Numbers as files for other programs: comma-separated values."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterable

FORMULAS = ("=", "+", "-", "@", "\t", "\r")  # a cell that begins so is computed by spreadsheets, and names are anybody's


def comma_separated(rows: Iterable[dict]) -> str:
    """A line for every row under one of names, the columns of all rows; what a row lacks is empty. A row within a row gives
    a column for each of its fields, named outer.inner."""
    flat = [dict(_flat(row)) for row in rows]
    names = list(dict.fromkeys(name for row in flat for name in row))
    text = io.StringIO()
    writer = csv.DictWriter(text, names, lineterminator="\n")
    writer.writeheader()
    writer.writerows(flat)
    return text.getvalue()


def _flat(row: dict, before: str = "") -> Iterable[tuple[str, object]]:
    for name, value in row.items():
        if isinstance(value, dict):
            yield from _flat(value, f"{before}{name}.")
        elif isinstance(value, str) and value.startswith(FORMULAS):
            yield before + name, "'" + value
        else:
            yield before + name, value
