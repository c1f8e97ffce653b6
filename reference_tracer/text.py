"""Text for terminals: lines and tables that fit their width. What goes to a file or a pipe is not wrapped."""

from __future__ import annotations

import itertools
import shutil
import textwrap
from collections.abc import Sequence

ENDLESS = 1_000_000
NARROW = 36  # columns: prose in less than that reads better below than beside


def width() -> int:
    """Columns of the terminal, or COLUMNS of the environment; ENDLESS where neither is."""
    return shutil.get_terminal_size((ENDLESS, 24)).columns


def hanging(first: str, prose: str, gap: int = 1, indent: int = 4) -> str:
    """`prose` beside `first`, its further lines under its first one; below, where there is too little room beside."""
    start = len(first) + gap
    if not prose.strip() or start + len(prose) <= width():
        return f"{first}{'':{gap}}{prose}".rstrip()
    if width() - start >= NARROW:
        lines = textwrap.wrap(prose, width() - start, break_long_words=False, break_on_hyphens=False)
        return f"{first}{'':{gap}}" + f"\n{'':{start}}".join(lines)
    lines = textwrap.wrap(prose, max(width() - indent, 1), break_long_words=False, break_on_hyphens=False)
    return "\n".join([*filter(None, [first.rstrip()]), *(f"{'':{indent}}{line}" for line in lines)])


def table(heads: Sequence[str], rows: Sequence[Sequence[str]], left: Sequence[int] = (0,), indent: int = 0) -> str:
    """Heads over columns, numbers at the right but for those of `left`. What is wider than the terminal has heads of several
    lines; what still is comes in parts, each of which begins with the first column."""
    side = lambda words, k, wide: [f"{word:<{wide}}" if k in left else f"{word:>{wide}}" for word in words]

    def part(chosen: Sequence[int], wraps: bool) -> list[str]:
        built = []
        for k in chosen:
            cells = [row[k] for row in rows]
            wide = max(map(len, cells), default=0)
            head = textwrap.wrap(heads[k], max([wide, *map(len, heads[k].split())]) or 1) if wraps else [heads[k]]
            wide = max(wide, *map(len, head), 0)
            built.append((head, cells, wide, k))
        height = max(len(head) for head, *_ in built)
        whole = [side([""] * (height - len(head)) + head + cells, k, wide) for head, cells, wide, k in built]
        return [(" " * indent + "  ".join(cells)).rstrip() for cells in zip(*whole)]

    wide = lambda lines: max(map(len, lines), default=0)
    everything = range(len(heads))
    lines = part(everything, False)
    if wide(lines) <= width():
        return "\n".join(lines)
    parts, chosen = [], [0]
    for k in everything[1:]:
        if len(chosen) > 1 and wide(part([*chosen, k], True)) > width():
            parts.append(chosen)
            chosen = [0]
        chosen.append(k)
    return "\n\n".join("\n".join(part(chosen, True)) for chosen in [*parts, chosen])


def side_by_side(left: Sequence[str], right: Sequence[str]) -> str:
    """Two lists of lines, the second one below the first where the terminal is too narrow for both."""
    wide = max(map(len, left), default=0)
    if wide + 5 + max(map(len, right), default=0) > width():
        return "\n".join([*left, "", *right])
    return "\n".join(f"{a:<{wide}}  |  {b}".rstrip() for a, b in itertools.zip_longest(left, right, fillvalue=""))
