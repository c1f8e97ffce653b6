"""Objects that never show: no ray meets them, and without them no shadow is missing."""

from __future__ import annotations

from reference_tracer.scene.model import Scene

from ..search import Decision, Search

MOST_TRIALS = 16  # beyond them objects stay


def without(scene: Scene, dropped: set[int]) -> Scene:
    return scene.model_copy(update={"objects": tuple(o for k, o in enumerate(scene.objects) if k not in dropped)})


def decide(search: Search) -> list[Decision]:
    count = len(search.written.objects)
    unseen = [k for k in range(count) if not search.seen.met(k)][:count - 1]  # a scene has one object at least
    name = lambda k: search.written.objects[k].name or f"object {k + 1}"
    if not unseen:
        return [Decision("objects", str(count), str(count), "rays meet every one of them")]
    dropped: set[int] = set()
    groups, trials = [unseen], 0
    while groups and trials < MOST_TRIALS:
        group = groups.pop()
        trials += 1
        if search.holds("without " + ", ".join(map(name, group)), lambda s: without(s, dropped | set(group))):
            dropped |= set(group)
        elif len(group) > 1:
            middle = len(group) // 2
            groups += [group[:middle], group[middle:]]
    if not dropped:
        return [Decision("objects", str(count), str(count), "those that no ray meets cast shadows", None, search.tried())]
    listed = ", ".join(name(k) for k in sorted(dropped))
    return [Decision("objects", str(count), str(count - len(dropped)), f"no ray meets {listed}, and no shadow misses them",
                     lambda s: without(s, dropped), search.tried())]
