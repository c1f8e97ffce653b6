"""How many generations of secondary rays are needed."""

from __future__ import annotations

from ..ladder import cheapest
from ..search import Decision, Search, changing


def decide(search: Search) -> list[Decision]:
    written, used = search.written.tracing.max_depth, search.seen.generations
    if written == 0:
        return [Decision("recursion depth", "0", "0", "no generation is asked for")]
    found = cheapest(range(min(used, written - 1) + 1),
                     lambda k: search.holds(str(k), lambda s: s.traced_with(max_depth=k)))
    trials = search.tried()
    if found is None:
        return [Decision("recursion depth", str(written), str(written), "the last generation shows", None, trials)]
    change = next(t.change for t in trials if t.value == str(found))
    less = next((f"; with {found - 1} by {t.change:.2g}" for t in trials if t.value == str(found - 1)), "")
    return [Decision("recursion depth", str(written), str(found),
                     f"rays reach generation {used}; with {found} {changing(change)}{less}",
                     lambda s: s.traced_with(max_depth=found), trials)]
