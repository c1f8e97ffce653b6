"""Exact first hits, which miss nothing, against a C++ port whose steps are so small that it misses little."""

from __future__ import annotations

from reference_tracer.scene import library

from ..contestants import cpp_port, tracer
from ..options import Options, picture
from ..results import Row
from ..timing import row, take_turns

NAME = "exact-vs-port"
CASES = library.names()
MOST_RAYS = 640 * 480
STEP_SIZE, BAR = 0.01, 60.0


def measure(case: str, options: Options) -> list[Row]:
    scene = options.sized(case, MOST_RAYS)
    measured = take_turns([tracer("exact", scene, "exact"),
                           cpp_port("C++ port", scene.traced_with(step_size=STEP_SIZE))], options.turns, options.budget)
    return [row(f"{NAME}/{case}", f"C++ port at step size {STEP_SIZE:g} / exact", measured, "C++ port", "exact", BAR,
                options.clock, picture=picture(scene))]
