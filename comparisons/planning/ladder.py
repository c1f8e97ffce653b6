"""The cheapest value that holds, by bisection."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TypeVar

Rung = TypeVar("Rung")


def cheapest(rungs: Sequence[Rung], holds: Callable[[Rung], bool]) -> Rung | None:
    """The first of `rungs`, which run from cheap to dear, that holds; None if none does.

    Asks log2(len(rungs) + 1) of them, supposing that a dearer rung holds where a cheaper one does. Whatever is
    returned has been asked and has held, whether or not that is so.
    """
    low, high, found = 0, len(rungs), None
    while low < high:
        middle = (low + high) // 2
        if holds(rungs[middle]):
            high, found = middle, rungs[middle]
        else:
            low = middle + 1
    return found
