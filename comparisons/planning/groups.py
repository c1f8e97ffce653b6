"""Which of many things can be left out, together: groups are tried, and halved where they cannot."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TypeVar

Thing = TypeVar("Thing")


def removable(groups: Sequence[Sequence[Thing]], holds: Callable[[list[Thing]], bool], most: int) -> list[Thing]:
    """Things that can be left out; `holds` is asked with all of them at a time, at most `most` times.

    Things of one group are likely to share their fate.
    """
    removed: list[Thing] = []
    waiting = [list(group) for group in reversed(groups) if group]
    for _ in range(most):
        if not waiting:
            break
        group = waiting.pop()
        if holds(removed + group):
            removed += group
        elif len(group) > 1:
            middle = len(group) // 2
            waiting += [group[middle:], group[:middle]]
    return removed
