"""How far rays must go: a little farther than the farthest hit."""

from __future__ import annotations

import math

from ..search import Decision, Search

SPARE = 1.05  # beyond the farthest hit of a deciding pixel's ray: held-back pixels lie between those


def decide(search: Search) -> list[Decision]:
    written, farthest = search.written.tracing.max_distance, search.seen.farthest
    found = _rounded_up(SPARE * farthest)
    evidence = f"the farthest hit is {farthest:.4g} away"
    if farthest == 0 or found >= written:
        return [Decision("max_distance", f"{written:g}", f"{written:g}", evidence)]
    change = lambda s: s.traced_with(max_distance=found)
    if not search.holds(f"{found:g}", change):
        return [Decision("max_distance", f"{written:g}", f"{written:g}", evidence, None, search.tried())]
    return [Decision("max_distance", f"{written:g}", f"{found:g}", evidence, change, search.tried())]


def _rounded_up(value: float) -> float:
    """To two digits."""
    if value <= 0:
        return value
    unit = 10.0 ** (math.floor(math.log10(value)) - 1)
    return math.ceil(value / unit) * unit
