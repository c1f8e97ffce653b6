"""What a plan saves: both scenes rendered in turn."""

from __future__ import annotations

from collections.abc import Callable

from reference_tracer.render import Picture, Renderer, render
from reference_tracer.scene.model import Scene

from ..bench.timing import QUIET, Contestant, take_turns, timed
from .results import Ratio, Saved
from .yardstick import COLOUR

TURNS = 9
BUDGET = 20.0  # seconds
METHODS = ("exact", "paper")  # with which the scene as written is rendered


def measure(written: Scene, planned: Scene, turns: int = TURNS) -> Saved:
    """Ratios of time, everything compiled before: of the colours of a scene that is made ready, as for a picture after
    the first; and of a call of `render` with all planes and everything it does each time."""
    replays = {"planned": Renderer(planned), **{method: Renderer(written, method) for method in METHODS}}
    work: dict[str, Callable[[], Picture]] = {
        **{name: lambda r=renderer: r.picture(COLOUR) for name, renderer in replays.items()},
        "planned, render()": lambda: render(planned, "exact"),
        "exact, render()": lambda: render(written, "exact"),
    }
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
    pairs = {**{method: (method, "planned") for method in METHODS}, "exact, render()": ("exact, render()", "planned, render()")}
    ratios = [Ratio(method=name, wall=measured.ratio(*pair, "wall"), cpu=measured.ratio(*pair, "cpu"), clock=clock)
              for name, pair in pairs.items()]
    return Saved(ratios=ratios, turns=len(measured.costs["planned"]), others=round(measured.others, 3),
                 seconds=measured.seconds(), rays={name: rays[name] for name in replays})
