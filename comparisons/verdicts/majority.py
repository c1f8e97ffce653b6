"""The odd one out, by majority of independent stages.

A picture hangs on stages: where its surfaces come from, who finds hits on them, who shades them. Renderers that share one
are wrong together: two tracers of one mesh see the same triangles. So what is looked for is the smallest set of stages
without which all that are left agree, two of which at least share no stage: one voice alone agrees with itself. If more
than one set will do, nobody can say who is wrong, and no name decides.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from itertools import combinations

from ..results import Run

SHADING = {"reference": "the reference's shading", "povray": "POV-Ray's shading"}
FOREIGN = "the document's shading on other tracers' hits"  # Mitsuba's, Embree's and raysect's hits: one reading of it


@dataclass(frozen=True)
class Odd:
    """`suspects` are wrong together, by `stages` that they share; or, where it is a `split`, at least one of them is.

    `against` are those they disagree with."""

    suspects: tuple[str, ...]
    against: tuple[str, ...]
    stages: tuple[str, ...] = ()
    split: bool = False


def stages_of(run: Run, implementation: str) -> frozenset[str]:
    """What a finished run's picture hangs on; `implementation` is the module that made it."""
    facts, found = run.facts, {SHADING.get(implementation, FOREIGN), f"tracing by {run.renderer.partition('-')[0]}"}
    if facts.get("triangles"):
        found.add("hits moved onto f" if facts.get("refined") else f"meshes of {run.settings.get('resolution')} cells")
    if facts.get("grids"):
        found.add("grids")
    if facts.get("native_shapes"):
        found.add("Mitsuba's own shapes")
    return frozenset(found)


def odd_ones(stages: Mapping[str, frozenset[str]], disagree: Iterable[tuple[str, str]]) -> Odd | None:
    """Who is wrong among renderers with these `stages`; None where all agree.

    `disagree` are the pairs whose limits are exceeded. A pair that was not compared counts as agreeing.
    """
    pairs = {frozenset(pair) for pair in disagree}
    involved = tuple(name for name in stages if any(name in pair for pair in pairs))
    if not involved:
        return None
    known = sorted(set().union(*stages.values()))
    for size in range(1, len(known) + 1):
        found: dict[tuple[str, ...], tuple[str, ...]] = {}
        for removed in combinations(known, size):
            out = tuple(name for name in stages if stages[name] & set(removed))
            left = set(stages) - set(out)
            if not any(pair <= left for pair in pairs) and any(
                    not stages[a] & stages[b] for a, b in combinations(left, 2)):
                found.setdefault(out, removed)
        least = {out: removed for out, removed in found.items() if not any(set(o) < set(out) for o in found)}
        if len(least) == 1:
            (out, removed), = least.items()
            suspects = tuple(name for name in out if name in involved)
            return Odd(suspects, tuple(n for n in stages if n not in out and any({n, s} in pairs for s in suspects)), removed)
        if found:
            break
    return Odd(involved, involved, split=True)
