"""What a plan saves: both scenes rendered in turn, through the entry that everybody uses."""

from __future__ import annotations

from reference_tracer.render import render
from reference_tracer.scene.model import Scene

from ..bench.timing import QUIET, Contestant, take_turns, timed
from .results import Ratio, Saved

TURNS = 7
BUDGET = 40.0  # seconds
METHODS = ("exact", "paper")  # with which the scene as written is rendered
PLANNED = "planned"


def measure(written: Scene, planned: Scene, turns: int = TURNS) -> Saved:
    """Ratios of time, everything compiled before, and numbers of rays."""
    scenes = {PLANNED: (planned, "exact"), **{method: (written, method) for method in METHODS}}
    rays: dict[str, int] = {}

    def contestant(name: str) -> Contestant:
        def run():
            pictures = []
            cost = timed(lambda: pictures.append(render(*scenes[name])))
            rays[name] = pictures[0].metadata["rays"]
            return cost
        return Contestant(name, run)

    measured = take_turns([contestant(name) for name in scenes], turns, BUDGET)
    clock = "wall" if measured.others < QUIET else "cpu"
    ratios = [Ratio(method=method, wall=measured.ratio(method, PLANNED, "wall"), cpu=measured.ratio(method, PLANNED, "cpu"),
                    clock=clock) for method in METHODS]
    return Saved(ratios=ratios, turns=len(measured.costs[PLANNED]), others=round(measured.others, 3),
                 seconds=measured.seconds(), rays=rays)
