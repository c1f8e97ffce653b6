"""How the first hits of each object are found: the fastest method whose errors do not show."""

from __future__ import annotations

from collections.abc import Iterator

from reference_tracer.first_hit.exact import cheapest_exact
from reference_tracer.scene.model import MOST_STEPS, FirstHitChoice, Object

from ..ladder import cheapest
from ..search import CHEAPER, Change, Decision, Search

STEPS = tuple(4 * 2.0**-k for k in range(8))  # step sizes, 4 to 0.03: smaller ones take longer than exact methods
MOST_TRIED = 4  # kinds of surfaces without a closed form; others stay as written


def decide(search: Search) -> Iterator[Decision]:
    families: dict[tuple, list[Object]] = {}
    for obj in search.scene.objects:
        families.setdefault(obj.surface.family, []).append(obj)
    tried = 0
    for family, members in sorted(families.items(), key=lambda entry: _closed_form(entry[1][0])):
        yield _decide(search, family, members, tried < MOST_TRIED)
        tried += not _closed_form(members[0])

def _decide(search: Search, family: tuple, members: list[Object], trying: bool) -> Decision:
    """One decision for all objects that share f: they are in the same kernels anyway."""
    what = f"first hit of {_told(members)}"
    written = ", ".join(sorted({_method(o.first_hit) for o in members}))
    if _closed_form(members[0]):
        change = None if written == "exact" else _choosing(family, None)
        return Decision(what, written, "exact", "a closed form: nothing is cheaper", change)
    if not trying:
        return Decision(what, written, written, "too many kinds of surfaces to try them all")
    candidates = {"exact": _choosing(family, None)}
    step = cheapest([h for h in STEPS if search.written.tracing.max_distance / h <= MOST_STEPS],
                    lambda h: search.holds(f"paper, step {h:.4g}", _choosing(family, _paper(h))))
    if step is not None:
        candidates[f"paper, step {step:.4g}"] = _choosing(family, _paper(step))
    for method in ("descartes", "interval"):
        if search.holds(method, change := _choosing(family, FirstHitChoice(method=method))):
            candidates[method] = change
    trials = search.tried()
    seconds = search.seconds({name: change(search.scene) for name, change in candidates.items()})
    best = min(seconds, key=seconds.get)
    if seconds[best] > CHEAPER * seconds["exact"]:
        best = "exact"
    evidence = "processor time of a picture: " + ", ".join(f"{name} {1e3 * s:.0f} ms" for name, s in seconds.items())
    return Decision(what, written, best, evidence, None if best == written else candidates[best], trials)


def _choosing(family: tuple, choice: FirstHitChoice | None) -> Change:
    return lambda scene: scene.model_copy(update={"objects": tuple(
        o.model_copy(update={"first_hit": choice}) if o.surface.family == family else o for o in scene.objects)})


def _paper(step: float) -> FirstHitChoice:
    return FirstHitChoice(method="paper", step_size=step)


def _closed_form(obj: Object) -> bool:
    return cheapest_exact(obj.surface.degree, obj.surface.box() is not None).closed_form


def _method(choice: FirstHitChoice | None) -> str:
    if choice is None:
        return "exact"
    return choice.method + (f", step {choice.step_size:g}" if choice.step_size else "")


def _told(members: list[Object]) -> str:
    kind = members[0].surface.type
    return kind if len(members) == 1 else f"{len(members)} {'tori' if kind == 'torus' else kind + 's'}"
