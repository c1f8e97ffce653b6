"""How much weight a secondary ray must have to be traced."""

from __future__ import annotations

from ..ladder import cheapest
from ..search import Decision, Search

LADDER = tuple(10 ** (-k / 10) for k in range(51))  # of cutoffs, 1 to 1e-5


def decide(search: Search) -> list[Decision]:
    written = search.written.tracing.cutoff
    if search.seen.generations == 0:
        return [Decision("cutoff", f"{written:g}", f"{written:g}", "no ray has a secondary one")]
    found = cheapest([c for c in LADDER if c > written],
                     lambda c: search.holds(f"{c:.2g}", lambda s: s.traced_with(cutoff=c)))
    trials = search.tried()
    if found is None:
        return [Decision("cutoff", f"{written:g}", f"{written:g}", "every smaller weight shows", None, trials)]
    worst = next(t.change for t in trials if t.value == f"{found:.2g}")
    evidence = f"all rays left out change a pixel by {worst:.2g} at most"
    return [Decision("cutoff", f"{written:g}", f"{found:.2g}", evidence,
                     lambda s: s.traced_with(cutoff=found), trials)]
