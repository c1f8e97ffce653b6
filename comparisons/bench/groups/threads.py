"""Two threads against one. Only wall time can tell, so a machine that is not quiet cannot."""

from __future__ import annotations

from reference_tracer.errors import UnsupportedError

from ..contestants import tracer
from ..options import Options, picture
from ..results import Row
from ..timing import QUIET, row, take_turns

NAME = "threads"
CASES = ("figure-02-16-samples", "figure-07-torus", "figure-17-scene1", "figure-18-scene2")
MOST_RAYS = 1440 * 1080
BAR = 1.85


def measure(case: str, options: Options) -> list[Row]:
    scene = options.sized(case, MOST_RAYS)
    measured = take_turns([tracer("1 thread", scene, "exact", threads=1),
                           tracer("2 threads", scene, "exact", threads=2)], options.turns, options.budget)
    if measured.others > QUIET:
        raise UnsupportedError(f"other programs kept {measured.others:.2f} cores busy, and only wall time can tell")
    return [row(f"{NAME}/{case}", "1 thread / 2 threads, exact", measured, "1 thread", "2 threads", BAR, "wall",
                picture=picture(scene))]
