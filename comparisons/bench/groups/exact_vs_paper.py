"""Exact first hits against the document's method, both ours: missing nothing should cost nothing."""

from __future__ import annotations

from reference_tracer.scene import library

from ..contestants import tracer
from ..options import Options, picture
from ..results import Row
from ..timing import row, take_turns

NAME = "exact-vs-paper"
CASES = library.names()
MOST_RAYS = 2_000_000
STEP_SIZE, BAR = 0.1, 1.0


def measure(case: str, options: Options) -> list[Row]:
    scene = options.sized(case, MOST_RAYS).traced_with(step_size=STEP_SIZE)
    measured = take_turns([tracer("exact", scene, "exact"), tracer("paper", scene, "paper")],
                          options.turns, options.budget)
    return [row(f"{NAME}/{case}", f"paper at step size {STEP_SIZE:g} / exact", measured, "paper", "exact", BAR,
                options.clock, picture=picture(scene))]
