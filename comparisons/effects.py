"""Decisions with a visible effect: the same scene, once as decided and once otherwise."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

from raytruth.reference_tracer.scene.model import Scene

from .results import Effect, Run
from .runs import Request
from .verdicts.pairs import Measurements, Pair


@dataclass(frozen=True)
class Alternative:
    """A decision and a scene on which doing otherwise shows: other parameters of tracing, or of the camera."""

    decision: str
    scene: str
    change: str
    traced_with: dict
    method: str
    why: Callable[[dict], str]
    camera: dict = field(default_factory=dict)

    def of(self, scene: Scene) -> Scene:
        """`scene`, otherwise."""
        return scene.traced_with(**self.traced_with).seen_by(**self.camera)


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
    # what the document's figures do otherwise than its text
    Alternative("F1", "figure-17-scene1", "lights that share what is dark yet, as in the figures", {"lights": "balanced"},
                "exact",
                lambda m: f"Where several lights arrive it is less bright than their sum: {_share(m)}."),
    Alternative("F2", "figure-17-scene1", "an ambient light of 0.1, as in the figure", {"ambient": 0.1}, "exact",
                lambda m: f"No shadow is black: {_share(m)}."),
    *(Alternative("F3", name, "transparent objects that cast no shadow, as in the figures", {"shadows": "opaque_only"}, "exact",
                  lambda m: f"What lies in the shadow of glass, and glass itself from within, turns brighter: {_share(m)}.")
      for name in ("figure-16-refraction-n1.4", "figure-17-scene1")),
    *(Alternative("F4", name, "one range for a whole path, as in the figures", {"range": "path"}, "exact",
                  lambda m: f"What is seen in mirrors within mirrors ends early, in the background: {_share(m)}.")
      for name in ("figure-10-refraction-n0.8", "figure-18-scene2")),
    Alternative("F5", "figure-19-scene3", "axes of the canvas that stay the world's x and y, as in the figure", {}, "exact",
                lambda m: f"The picture is sheared, and its middle stays: {_share(m)}.",
                {"v_x": (1.0, 0.0, 0.0), "v_y": (0.0, 1.0, 0.0)}),
)


def requests(scenes: Sequence[Scene]) -> list[Request]:
    """The runs that show the effects on those of `scenes` that have one."""
    return [request for pair in _pairs(scenes) for request in pair[1:]]


def pairs(scenes: Sequence[Scene], runs: dict[str, Run]) -> list[Pair]:
    """The pictures that show them, where there are both."""
    return [pair for _, pair in _compared(scenes, runs)]


def effects(scenes: Sequence[Scene], runs: dict[str, Run], measurements: Measurements) -> list[Effect]:
    """The effects that could be measured."""
    return [Effect(id=f"{alternative.decision}--{alternative.scene}", decision=alternative.decision,
                   scene=alternative.scene, change=alternative.change, finding=alternative.why(found.metrics),
                   baseline=pair.first.key, variant=pair.second.key, metrics=found.metrics)
            for alternative, pair in _compared(scenes, runs) if (found := measurements.of(pair)).state == "ok"]


def _compared(scenes: Sequence[Scene], runs: dict[str, Run]) -> list[tuple[Alternative, Pair]]:
    found = [(alternative, Pair(with_it.scene, runs[with_it.key], runs[without.key]))
             for alternative, with_it, without in _pairs(scenes)]
    return [(alternative, pair) for alternative, pair in found if pair.first.state == pair.second.state == "ok"]


def _pairs(scenes: Sequence[Scene]) -> list[tuple[Alternative, Request, Request]]:
    by_name = {scene.name: scene for scene in scenes}
    changed = lambda a: Request(a.of(by_name[a.scene]), a.method, changes=a.traced_with, camera=a.camera)
    return [(a, Request(by_name[a.scene], a.method), changed(a)) for a in ALTERNATIVES if a.scene in by_name]
