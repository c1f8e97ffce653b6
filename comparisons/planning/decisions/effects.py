"""Which of shadow, reflection and refraction matter at all."""

from __future__ import annotations

from collections.abc import Iterator

from reference_tracer.scene.model import EFFECTS, Scene

from ..search import Decision, Search, changing


def decide(search: Search) -> Iterator[Decision]:
    for effect in EFFECTS:
        if effect in search.written.tracing.effects:
            yield _decide(search, effect)


def _decide(search: Search, effect: str) -> Decision:
    def change(scene: Scene) -> Scene:
        return scene.traced_with(effects=tuple(e for e in scene.tracing.effects if e != effect))

    if not _possible(search.written, effect):
        return Decision(effect, "traced", "left out", "the scene has none", change)
    fits = search.holds(f"without {effect}", change)
    trials = search.tried()
    evidence = f"without it {changing(trials[-1].change)}"
    return Decision(effect, "traced", "left out" if fits else "traced", evidence, change if fits else None, trials)


def _possible(scene: Scene, effect: str) -> bool:
    materials = [o.material for o in scene.objects]
    match effect:
        case "shadow":
            return bool(scene.lights)
        case "reflection":  # total reflection is one, too
            return any(m.reflection > 0 or m.transparency > 0 for m in materials)
        case _:
            return any(m.transparency > 0 for m in materials)
