"""POV-Ray with its native primitives against exact first hits: full pictures of the document's scenes.

POV-Ray's process takes most of a second to start; the processor time of tracing alone is compared.
"""

from __future__ import annotations

from reference_tracer.scene import library

from ..contestants import pov_ray, tracer
from ..options import Options, picture
from ..results import Row
from ..timing import row, take_turns

NAME = "povray-native"
CASES = library.names()
MOST_RAYS = 1440 * 1080
BAR = 4.0


def measure(case: str, options: Options) -> list[Row]:
    scene = options.sized(case, MOST_RAYS)
    measured = take_turns([tracer("exact", scene, "exact"), pov_ray("POV-Ray", scene, shapes="native")],
                          options.turns, options.budget)
    return [row(f"{NAME}/{case}", "POV-Ray, native primitives / exact", measured, "POV-Ray", "exact", BAR, "cpu",
                picture=picture(scene))]
