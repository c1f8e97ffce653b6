"""What is decided, in the order of ORDER: one function a parameter, from a search to decisions.

Each decision is in force as soon as it is made, and every trial after it is judged together with it. Where nothing
changes, a decision's `change` is None.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterable, Iterator, Sequence
from typing import TypeVar

from raytruth.reference_tracer.first_hit.exact import cheapest_exact
from raytruth.reference_tracer.scene.model import EFFECTS, MOST_STEPS, FirstHitChoice, Object, Scene

from .search import Change, Decision, Search

T = TypeVar("T")

CHEAPER = 0.95  # of the time: a smaller gain is within the noise of a few turns
MOST_TRIALS = 16  # of objects, and of shadows: beyond them they stay
THRESHOLDS = tuple(0.5 * 2.0**-k for k in range(14))  # of adaptive samples, 0.5 to 6e-5
CUTOFFS = tuple(10 ** (-k / 10) for k in range(51))  # 1 to 1e-5
STEPS = tuple(4 * 2.0**-k for k in range(8))  # step sizes, 4 to 0.03: smaller ones take longer than exact methods
MOST_FAMILIES = 4  # kinds of surfaces without a closed form that are tried; others stay as written
SPARE = 1.05  # beyond the farthest hit of a deciding pixel's ray: held-back pixels lie between those


def cheapest(candidates: Sequence[T], holds: Callable[[T], bool]) -> T | None:
    """The first of `candidates`, which run from cheap to dear, that holds; None if none does.

    Asks log2(len(candidates) + 1) of them, supposing that a dearer one holds where a cheaper one does. Whatever is
    returned has been tried and has held, whether or not that is so.
    """
    low, high, found = 0, len(candidates), None
    while low < high:
        middle = (low + high) // 2
        if holds(candidates[middle]):
            high, found = middle, candidates[middle]
        else:
            low = middle + 1
    return found


def removable(groups: Sequence[Sequence[T]], holds: Callable[[list[T]], bool], most: int) -> list[T]:
    """Things that can be left out together: groups are tried, and halved where they cannot.

    `holds` is asked with all of them at a time, at most `most` times. Things of one group are likely to share their fate.
    """
    removed: list[T] = []
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


def _stays(search: Search, parameter: str, written: str, evidence: str) -> list[Decision]:
    return [Decision(parameter, written, written, evidence, None, search.tried())]


def _changing(change: float) -> str:
    """The largest change of a picture, in words."""
    return f"a pixel changes by {change:.2g}" if change else "no pixel changes"


def objects(search: Search) -> list[Decision]:
    """Objects that never show: no ray meets them, and without them no shadow is missing."""
    count = len(search.written.objects)
    unmet = [k for k in range(count) if not search.rays.met(k)][:count - 1]  # a scene has one object at least
    if not unmet:
        return _stays(search, "objects", str(count), "rays meet every one of them")
    dropped = removable([unmet], lambda group: search.holds(f"without {search.named(group)}", _without(group)), MOST_TRIALS)
    if not dropped:
        return _stays(search, "objects", str(count), "those that no ray meets cast shadows")
    evidence = f"no ray meets {search.named(dropped)}, and no shadow misses them"
    return [Decision("objects", str(count), str(count - len(dropped)), evidence, _without(dropped), search.tried())]


def _without(dropped: Collection[int]) -> Change:
    return lambda scene: scene.model_copy(update={
        "objects": tuple(o for k, o in enumerate(scene.objects) if k not in dropped)})


def effects(search: Search) -> Iterator[Decision]:
    """Which of shadow, reflection and refraction matter at all."""
    materials = [o.material for o in search.written.objects]
    clear = any(m.transparency > 0 for m in materials)
    possible = {"shadow": bool(search.written.lights), "refraction": clear,
                "reflection": clear or any(m.reflection > 0 for m in materials)}  # total reflection is one, too
    for effect in (e for e in EFFECTS if e in search.written.tracing.effects):
        def change(scene: Scene, effect=effect) -> Scene:
            return scene.traced_with(effects=tuple(e for e in scene.tracing.effects if e != effect))

        if not possible[effect]:
            yield Decision(effect, "traced", "left out", "the scene has none", change)
            continue
        fits = search.holds(f"without {effect}", change)
        trials = search.tried()
        yield Decision(effect, "traced", "left out" if fits else "traced", f"without it {_changing(trials[-1].change)}",
                       change if fits else None, trials)


def samples(search: Search) -> list[Decision]:
    """More than one sample only where edges are."""
    tracing = search.written.tracing
    n = tracing.samples
    written = f"{n} x {n}" + (f", adaptive {tracing.adaptive:g}" if tracing.adaptive else "")
    if n == 1:
        return _stays(search, "samples", written, "one is the least there is")
    if search.holds("1 x 1", one := lambda s: s.traced_with(samples=1)):
        return [Decision("samples", written, "1 x 1", "no pixel has an edge", one, search.tried())]
    less = n // 2
    fewer = less > 1 and search.holds(f"{less} x {less}", lambda s: s.traced_with(samples=less))
    used = less if fewer else n
    found = cheapest([t for t in THRESHOLDS if t > tracing.adaptive],
                     lambda t: search.holds(f"{used} x {used}, adaptive {t:.2g}",
                                            lambda s: s.traced_with(samples=used, adaptive=t)))
    trials = search.tried()
    if found is None and not fewer:
        return [Decision("samples", written, written, f"with one {_changing(trials[0].change)}", None, trials)]
    threshold = tracing.adaptive if found is None else found
    planned = f"{used} x {used}" + (f" where neighbours differ by {threshold:.2g}" if threshold else "")
    return [Decision("samples", written, planned, f"with one sample everywhere {_changing(trials[0].change)}",
                     lambda s: s.traced_with(samples=used, adaptive=threshold), trials)]


def cutoff(search: Search) -> list[Decision]:
    """How much weight a secondary ray must have to be traced."""
    written = search.written.tracing.cutoff
    if search.rays.generations == 0:
        return _stays(search, "cutoff", f"{written:g}", "no ray has a secondary one")
    found = cheapest([c for c in CUTOFFS if c > written],
                     lambda c: search.holds(f"{c:.2g}", lambda s: s.traced_with(cutoff=c)))
    if found is None:
        return _stays(search, "cutoff", f"{written:g}", "every smaller weight shows")
    trials = search.tried()
    worst = next(t.change for t in trials if t.value == f"{found:.2g}")
    return [Decision("cutoff", f"{written:g}", f"{found:.2g}", f"all rays left out change a pixel by {worst:.2g} at most",
                     lambda s: s.traced_with(cutoff=found), trials)]


def recursion_depth(search: Search) -> list[Decision]:
    """How many generations of secondary rays are needed."""
    written, used = search.written.tracing.max_depth, search.rays.generations
    if written == 0:
        return _stays(search, "recursion depth", "0", "no generation is asked for")
    found = cheapest(range(min(used, written - 1) + 1),
                     lambda k: search.holds(str(k), lambda s: s.traced_with(max_depth=k)))
    if found is None:
        return _stays(search, "recursion depth", str(written), "the last generation shows")
    trials = search.tried()
    change = {t.value: t.change for t in trials}
    less = f"; with {found - 1} by {change[str(found - 1)]:.2g}" if str(found - 1) in change else ""
    return [Decision("recursion depth", str(written), str(found),
                     f"rays reach generation {used}; with {found} {_changing(change[str(found)])}{less}",
                     lambda s: s.traced_with(max_depth=found), trials)]


def precision(search: Search) -> list[Decision]:
    """Double or single precision."""
    written = f"fp{search.written.tracing.precision}"
    if written == "fp32":
        return _stays(search, "precision", written, "nothing is smaller")
    change = lambda s: s.traced_with(precision=32)
    fits = search.holds("fp32", change)
    trials = search.tried()
    shown = _changing(trials[0].change)
    if not fits:
        return [Decision("precision", written, written, f"in single precision {shown}", None, trials)]
    seconds = search.seconds({"fp64": search.scene, "fp32": change(search.scene)})
    if seconds["fp32"] > CHEAPER * seconds["fp64"]:
        return [Decision("precision", written, written, _timed(seconds), None, trials)]
    return [Decision("precision", written, "fp32", f"{_timed(seconds)}; {shown}", change, trials)]


def _timed(seconds: dict[str, float]) -> str:
    return "processor time of a picture: " + ", ".join(f"{name} {1e3 * s:.0f} ms" for name, s in seconds.items())


def shadows(search: Search) -> list[Decision]:
    """Which objects cast shadows that show."""
    objects = search.scene.objects
    casting = [k for k, o in enumerate(objects) if search.scene.casts_shadow(o)]
    parameter, written = "objects with shadows", str(len(casting))
    if not casting or not search.scene.lights or "shadow" not in search.scene.tracing.effects:
        return _stays(search, parameter, written, "no shadow is traced")
    families: dict[tuple, list[int]] = {}
    for k in casting:
        families.setdefault(objects[k].surface.family, []).append(k)
    named = lambda group: ", ".join(objects[k].name or f"object {k + 1}" for k in group)
    without = removable(list(families.values()), lambda group: search.holds(
        f"no shadow of {named(group)}", _without_shadow([objects[k] for k in group])), MOST_TRIALS)
    if not without:
        return _stays(search, parameter, written, "every one's shadow shows")
    return [Decision(parameter, written, str(len(casting) - len(without)), f"no shadow of {named(sorted(without))} shows",
                     _without_shadow([objects[k] for k in without]), search.tried())]


def _without_shadow(chosen: Collection[Object]) -> Change:
    """Objects are recognised by what they are, not by their place: an earlier decision may be withdrawn."""
    bare = lambda obj: obj.model_copy(update={"first_hit": None, "shadow": True})
    alike = [bare(o) for o in chosen]
    return lambda scene: scene.model_copy(update={"objects": tuple(
        o.model_copy(update={"shadow": False}) if bare(o) in alike else o for o in scene.objects)})


def first_hit(search: Search) -> Iterator[Decision]:
    """How the first hits of each object are found: the fastest method whose errors do not show."""
    families: dict[tuple, list[Object]] = {}
    for obj in search.scene.objects:
        families.setdefault(obj.surface.family, []).append(obj)
    tried = 0
    for family, members in sorted(families.items(), key=lambda entry: _closed_form(entry[1][0])):
        yield _first_hit(search, family, members, tried < MOST_FAMILIES)
        tried += not _closed_form(members[0])


def _first_hit(search: Search, family: tuple, members: list[Object], trying: bool) -> Decision:
    """One decision for all objects that share f: they are in the same kernels anyway."""
    def choosing(choice: FirstHitChoice | None) -> Change:
        return lambda scene: scene.model_copy(update={"objects": tuple(
            o.model_copy(update={"first_hit": choice}) if o.surface.family == family else o for o in scene.objects)})

    paper = lambda step: choosing(FirstHitChoice(method="paper", step_size=step))
    kind, many = members[0].surface.type, len(members)
    what = "first hit of " + (kind if many == 1 else f"{many} {'tori' if kind == 'torus' else kind + 's'}")
    written = ", ".join(sorted({_method(o.first_hit) for o in members}))
    if _closed_form(members[0]):
        return Decision(what, written, "exact", "a closed form: nothing is cheaper",
                        None if written == "exact" else choosing(None))
    if not trying:
        return Decision(what, written, written, "too many kinds of surfaces to try them all")
    candidates = {"exact": choosing(None)}
    step = cheapest([h for h in STEPS if search.written.tracing.max_distance / h <= MOST_STEPS],
                    lambda h: search.holds(f"paper, step {h:.4g}", paper(h)))
    if step is not None:
        candidates[f"paper, step {step:.4g}"] = paper(step)
    for method in ("descartes", "interval"):
        if search.holds(method, change := choosing(FirstHitChoice(method=method))):
            candidates[method] = change
    trials = search.tried()
    seconds = search.seconds({name: change(search.scene) for name, change in candidates.items()})
    best = min(seconds, key=seconds.get)
    if seconds[best] > CHEAPER * seconds["exact"]:
        best = "exact"
    return Decision(what, written, best, _timed(seconds), None if best == written else candidates[best], trials)


def _closed_form(obj: Object) -> bool:
    return cheapest_exact(obj.surface.degree, obj.surface.box() is not None).closed_form


def _method(choice: FirstHitChoice | None) -> str:
    if choice is None:
        return "exact"
    return choice.method + (f", step {choice.step_size:g}" if choice.step_size else "")


def max_distance(search: Search) -> list[Decision]:
    """How far rays must go: a little farther than the farthest hit."""
    written, farthest = search.written.tracing.max_distance, search.rays.farthest
    found = _rounded_up(SPARE * farthest)
    if search.written.tracing.range == "path":  # decision F4: the farthest hit says nothing of the longest path
        return _stays(search, "max_distance", f"{written:g}", "rays share it along their path")
    evidence = f"the farthest hit is {farthest:.4g} away"
    change = lambda s: s.traced_with(max_distance=found)
    if farthest == 0 or found >= written or not search.holds(f"{found:g}", change):
        return _stays(search, "max_distance", f"{written:g}", evidence)
    return [Decision("max_distance", f"{written:g}", f"{found:g}", evidence, change, search.tried())]


def _rounded_up(value: float) -> float:
    """To two digits."""
    if value <= 0:
        return value
    unit = 10.0 ** (math.floor(math.log10(value)) - 1)
    return math.ceil(value / unit) * unit


ORDER: tuple[Callable[[Search], Iterable[Decision]], ...] = (
    objects, effects, samples, cutoff, recursion_depth, precision, shadows, first_hit, max_distance)
