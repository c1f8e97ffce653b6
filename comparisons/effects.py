"""Decisions with a visible effect: the same scene, once as decided and once otherwise."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from reference_tracer.scene.model import Scene

from . import metrics
from .results import Effect, Run
from .runs import Request, RunStore


@dataclass(frozen=True)
class Alternative:
    """A decision and a scene on which doing otherwise shows."""

    decision: str
    scene: str
    change: str
    traced_with: dict
    method: str
    why: Callable[[dict], str]


def _share(m: dict) -> str:
    return f"{m['failing pixels']} of {m['pixels']} pixels change visibly, by up to {m['color max']:.2g}"


ALTERNATIVES = (
    *(Alternative("E1", name, "the sine of the refraction angle as printed", {"refraction": "as_printed"}, "exact",
                  lambda m: f"The printed formula bends light the wrong way round: {_share(m)}. Where its sine exceeds 1 "
                            "there is no direction at all: such rays see the background, and their pixels are marked "
                            "undecided.")
      for name in ("figure-10-refraction-n0.8", "figure-16-refraction-n1.4")),
    Alternative("E1", "figure-12-refraction-n1.0", "the sine of the refraction angle as printed",
                {"refraction": "as_printed"}, "exact",
                lambda m: f"At n = 1 both formulas agree: {m['failing pixels']} of {m['pixels']} pixels change visibly."),
    Alternative("M6", "figure-09-heart", "the literal method at a step of 0.1", {"step_size": 0.1}, "paper",
                lambda m: "Free Newton starts far from the triple root on the heart's belt and runs out of iterations: "
                          f"{_share(m)}."),
    Alternative("C2", "figure-05-sphere", "4 x 4 samples a pixel instead of one", {"samples": 4}, "exact",
                lambda m: f"Averaging softens edges and nothing else: {_share(m)}."),
    Alternative("D1", "figure-17-scene1", "one generation of secondary rays instead of eight", {"max_depth": 1}, "exact",
                lambda m: f"What is seen in mirrors within mirrors and through glass turns black: {_share(m)}."),
    Alternative("M5", "figure-reflection", "rays that end at 30 instead of 100", {"max_distance": 30.0}, "exact",
                lambda m: f"The floor ends early: {_share(m)}."),
)


def requests(scenes: Sequence[Scene]) -> list[Request]:
    """The runs that show the effects on those of `scenes` that have one."""
    return [request for pair in _pairs(scenes) for request in pair[1:]]


def effects(scenes: Sequence[Scene], runs: dict[str, Run], store: RunStore) -> list[Effect]:
    """The effects that could be measured."""
    found = []
    for alternative, with_it, without in _pairs(scenes):
        a, b = runs[with_it.key], runs[without.key]
        if a.state == b.state == "ok":
            planes = store.planes(a, with_it.scene), store.planes(b, without.scene)
            measured = {"pixels": planes[0]["t"].size, **metrics.picture(*planes)}
            found.append(Effect(id=f"{alternative.decision}--{alternative.scene}", decision=alternative.decision,
                                scene=alternative.scene, change=alternative.change, finding=alternative.why(measured),
                                baseline=a.key, variant=b.key, metrics=measured))
    return found


def _pairs(scenes: Sequence[Scene]) -> list[tuple[Alternative, Request, Request]]:
    by_name = {scene.name: scene for scene in scenes}
    return [(a, Request(by_name[a.scene], a.method), Request(by_name[a.scene].traced_with(**a.traced_with), a.method))
            for a in ALTERNATIVES if a.scene in by_name]
