"""What a plan saves: both scenes rendered in turn."""

from __future__ import annotations

from collections.abc import Callable

from reference_tracer.tracer.render import Picture, Renderer, render
from reference_tracer.scene.model import Scene

from ..bench.timing import QUIET, Contestant, take_turns, timed
from .results import Ratio, Saved
from .yardstick import COLOUR

TURNS = 9
BUDGET = 20.0  # seconds
PLANNED, EXACT, PAPER = "planned", "exact", "paper"
PLANNED_CALL, EXACT_CALL = f"{PLANNED}, whole call", f"{EXACT}, whole call"


def measure(written: Scene, planned: Scene, turns: int = TURNS) -> Saved:
    """Ratios of time, everything compiled before: of the colours of a scene that is made ready, as for every picture
    after the first; and of a call of `render` with all planes and everything it does each time."""
    ready = {PLANNED: Renderer(planned), EXACT: Renderer(written, EXACT), PAPER: Renderer(written, PAPER)}
    work: dict[str, Callable[[], Picture]] = {
        **{name: lambda renderer=renderer: renderer.picture(COLOUR) for name, renderer in ready.items()},
        PLANNED_CALL: lambda: render(planned), EXACT_CALL: lambda: render(written)}
    rays: dict[str, int] = {}

    def contestant(name: str) -> Contestant:
        def run():
            pictures = []
            cost = timed(lambda: pictures.append(work[name]()))
            rays[name] = pictures[0].metadata["rays"]
            return cost
        return Contestant(name, run)

    measured = take_turns([contestant(name) for name in work], turns, BUDGET)
    clock = "wall" if measured.others < QUIET else "cpu"

    def ratio(slow: str, fast: str) -> Ratio:
        return Ratio(wall=measured.ratio(slow, fast, "wall"), cpu=measured.ratio(slow, fast, "cpu"), clock=clock)

    return Saved(exact=ratio(EXACT, PLANNED), paper=ratio(PAPER, PLANNED), call=ratio(EXACT_CALL, PLANNED_CALL),
                 turns=len(measured.costs[PLANNED]), others=round(measured.others, 3), seconds=measured.seconds(),
                 rays_written=rays[EXACT], rays_planned=rays[PLANNED])
