"""Samples: more than one only where edges are."""

from __future__ import annotations

from ..ladder import cheapest
from ..search import Decision, Search, changing

LADDER = tuple(0.5 * 2.0**-k for k in range(14))  # thresholds, 0.5 to 6e-5


def decide(search: Search) -> list[Decision]:
    tracing = search.written.tracing
    n = tracing.samples
    written = f"{n} x {n}" + (f", adaptive {tracing.adaptive:g}" if tracing.adaptive else "")
    if n == 1:
        return [Decision("samples", written, written, "one is the least there is")]
    if search.holds("1 x 1", lambda s: s.traced_with(samples=1)):
        return [Decision("samples", written, "1 x 1", "no pixel has an edge", lambda s: s.traced_with(samples=1),
                         search.tried())]
    less = n // 2
    fewer = search.holds(f"{less} x {less}", lambda s: s.traced_with(samples=less)) if less > 1 else False
    used = less if fewer else n
    found = cheapest([t for t in LADDER if t > tracing.adaptive],
                     lambda t: search.holds(f"{used} x {used}, adaptive {t:.2g}",
                                            lambda s: s.traced_with(samples=used, adaptive=t)))
    trials = search.tried()
    if found is None and not fewer:
        return [Decision("samples", written, written, f"with one {changing(trials[0].change)}", None, trials)]
    threshold = tracing.adaptive if found is None else found
    planned = f"{used} x {used}" + (f" where neighbours differ by {threshold:.2g}" if threshold else "")
    return [Decision("samples", written, planned, f"with one sample everywhere {changing(trials[0].change)}",
                     lambda s: s.traced_with(samples=used, adaptive=threshold), trials)]
