"""The document's own method against a plain C++ port of it, at the same step size: full pictures."""

from __future__ import annotations

from ..contestants import RICH, SINGLE, cpp_port, tracer
from ..options import Options, picture
from ..results import Row
from ..timing import row, take_turns

NAME = "paper-vs-port"
CASES = SINGLE + RICH
MOST_RAYS = 640 * 480
RICH_BAR, SINGLE_BAR = 10.0, 15.0


def measure(case: str, options: Options) -> list[Row]:
    scene = options.sized(case, MOST_RAYS)
    measured = take_turns([tracer("paper", scene, "paper"), cpp_port("C++ port", scene)], options.turns, options.budget)
    return [row(f"{NAME}/{case}", "C++ port / paper, same step size", measured, "C++ port", "paper",
                RICH_BAR if case in RICH else SINGLE_BAR, options.clock,
                picture=picture(scene), note=f"step size {scene.tracing.step_size:g}")]
