"""Which objects cast shadows that show."""

from __future__ import annotations

from collections.abc import Collection

from reference_tracer.scene.model import Object

from ..groups import removable
from ..search import Change, Decision, Search

MOST_TRIALS = 16  # beyond them objects keep their shadows


def decide(search: Search) -> list[Decision]:
    objects = search.scene.objects
    casting = [k for k, o in enumerate(objects) if o.shadow]
    written = str(len(casting))
    if not casting or not search.scene.lights or "shadow" not in search.scene.tracing.effects:
        return [Decision("objects with shadows", written, written, "no shadow is traced")]
    families: dict[tuple, list[int]] = {}
    for k in casting:
        families.setdefault(objects[k].surface.family, []).append(k)
    named = lambda group: ", ".join(objects[k].name or f"object {k + 1}" for k in group)
    without = removable(list(families.values()), lambda group: search.holds(
        f"no shadow of {named(group)}", _without_shadow([objects[k] for k in group])), MOST_TRIALS)
    trials = search.tried()
    if not without:
        return [Decision("objects with shadows", written, written, "every one's shadow shows", None, trials)]
    evidence = f"no shadow of {named(sorted(without))} shows"
    return [Decision("objects with shadows", written, str(len(casting) - len(without)), evidence,
                     _without_shadow([objects[k] for k in without]), trials)]


def _without_shadow(chosen: Collection[Object]) -> Change:
    """Objects are told by what they are, not by their place: an earlier decision may be withdrawn."""
    alike = [_bare(o) for o in chosen]
    return lambda scene: scene.model_copy(update={"objects": tuple(
        o.model_copy(update={"shadow": False}) if _bare(o) in alike else o for o in scene.objects)})


def _bare(obj: Object) -> Object:
    return obj.model_copy(update={"first_hit": None, "shadow": True})
