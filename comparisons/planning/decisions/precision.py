"""Double or single precision."""

from __future__ import annotations

from ..search import CHEAPER, Decision, Search, changing


def decide(search: Search) -> list[Decision]:
    written = f"fp{search.written.tracing.precision}"
    if written == "fp32":
        return [Decision("precision", written, written, "nothing is smaller")]
    change = lambda s: s.traced_with(precision=32)
    fits = search.holds("fp32", change)
    trials = search.tried()
    if not fits:
        return [Decision("precision", written, written, f"in single precision {changing(trials[0].change)}",
                         None, trials)]
    seconds = search.seconds({"fp64": search.scene, "fp32": change(search.scene)})
    evidence = "processor time of a picture: " + ", ".join(f"{name} {1e3 * s:.0f} ms" for name, s in seconds.items())
    if seconds["fp32"] > CHEAPER * seconds["fp64"]:
        return [Decision("precision", written, written, evidence, None, trials)]
    return [Decision("precision", written, "fp32", f"{evidence}; {changing(trials[0].change)}", change, trials)]
