"""The decisions of the reference, read from the file that states them."""

from __future__ import annotations

import re
from dataclasses import dataclass
from importlib.resources import files


@dataclass(frozen=True)
class Decision:
    """One row of DECISIONS.md. Texts are Markdown of which only `code` is used; see `pieces`."""

    id: str
    section: str
    question: str
    decision: str


def read() -> list[Decision]:
    """The rows of reference_tracer/DECISIONS.md, in its order."""
    return parse(files("reference_tracer").joinpath("DECISIONS.md").read_text(encoding="utf-8"))


def parse(markdown: str) -> list[Decision]:
    """The rows of the table whose header is `id | section | question | decision`."""
    rows = [[cell.strip() for cell in line.strip().strip("|").split("|")]
            for line in markdown.splitlines() if line.lstrip().startswith("|")]
    header = ["id", "section", "question", "decision"]
    if header not in rows:
        raise ValueError("the decisions have no table with the columns " + ", ".join(header))
    return [Decision(*row) for row in rows[rows.index(header) + 2:]]


def pieces(text: str) -> list[tuple[bool, str]]:
    """`text` cut at its back quotes: (is code, text)."""
    return [(i % 2 == 1, piece) for i, piece in enumerate(re.split(r"`([^`]*)`", text)) if piece]
