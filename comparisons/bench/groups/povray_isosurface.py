"""POV-Ray's isosurface, the established tracer of f(x, y, z) = 0, against exact first hits on single surfaces.

POV-Ray's process takes most of a second to start; the processor time of tracing alone is compared.
"""

from __future__ import annotations

from ..contestants import SINGLE, pov_ray, tracer
from ..options import Options, picture
from ..results import Row
from ..timing import row, take_turns

NAME = "povray-isosurface"
CASES = SINGLE
MOST_RAYS = 640 * 480
ACCURACY, BAR = 1e-6, 20.0


def measure(case: str, options: Options) -> list[Row]:
    scene = options.sized(case, MOST_RAYS)
    measured = take_turns([tracer("exact", scene, "exact"),
                           pov_ray("POV-Ray", scene, shapes="isosurface", accuracy=ACCURACY)],
                          options.turns, options.budget)
    return [row(f"{NAME}/{case}", f"POV-Ray isosurface of accuracy {ACCURACY:g} / exact", measured, "POV-Ray", "exact",
                BAR, "cpu", picture=picture(scene))]
