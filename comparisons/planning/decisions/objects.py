"""Objects that never show: no ray meets them, and without them no shadow is missing."""

from __future__ import annotations

from collections.abc import Collection

from ..groups import removable
from ..search import Change, Decision, Search

MOST_TRIALS = 16  # beyond them objects stay


def decide(search: Search) -> list[Decision]:
    count = len(search.written.objects)
    unseen = [k for k in range(count) if not search.seen.met(k)][:count - 1]  # a scene has one object at least
    if not unseen:
        return [Decision("objects", str(count), str(count), "rays meet every one of them")]
    dropped = removable([unseen], lambda group: search.holds(f"without {search.named(group)}", _without(group)),
                        MOST_TRIALS)
    trials = search.tried()
    if not dropped:
        return [Decision("objects", str(count), str(count), "those that no ray meets cast shadows", None, trials)]
    evidence = f"no ray meets {search.named(dropped)}, and no shadow misses them"
    return [Decision("objects", str(count), str(count - len(dropped)), evidence, _without(dropped), trials)]


def _without(dropped: Collection[int]) -> Change:
    return lambda scene: scene.model_copy(update={
        "objects": tuple(o for k, o in enumerate(scene.objects) if k not in dropped)})
