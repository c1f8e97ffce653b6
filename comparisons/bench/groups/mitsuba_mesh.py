"""Mitsuba on a mesh just fine enough to have hardly a wrong pixel, against exact first hits."""

from __future__ import annotations

import numpy as np

from reference_tracer.errors import UnsupportedError
from reference_tracer.tracer.render import UNDECIDED, Picture, render
from reference_tracer.scene.model import Scene

from ...renderers import render as render_with
from ..contestants import SINGLE, tracer
from ..options import Options, picture
from ..results import Row
from ..timing import Contestant, Cost, row, take_turns, timed

NAME = "mitsuba-mesh"
CASES = SINGLE
MOST_RAYS = 640 * 480
MOST_WRONG = 10  # pixels that show another object, or none
RESOLUTIONS = (16, 24, 32, 48, 64, 96, 128, 192, 256, 384, 512)
WHOLE_BAR, TRACING_BAR = 10.0, 1.0


def measure(case: str, options: Options) -> list[Row]:
    scene = options.sized(case, MOST_RAYS)
    resolution, wrong = least_resolution(scene)
    tracing = []  # seconds without building, of every run

    def mesh() -> Cost:
        made = []
        cost = timed(lambda: made.append(_mesh(scene, resolution)))
        tracing.append(made[0].metadata["first"])
        return cost

    measured = take_turns([tracer("exact", scene, "exact"), Contestant("Mitsuba", mesh)], options.turns, options.budget)
    note = f"resolution {resolution}: {wrong} wrong pixels"
    whole = row(f"{NAME}/{case}/build-and-trace", "Mitsuba, mesh built and traced / exact", measured, "Mitsuba",
                "exact", WHOLE_BAR, options.clock, picture=picture(scene), note=note)
    measured.costs["Mitsuba"] = [Cost(seconds, seconds) for seconds in tracing[1:]]  # the first one compiled
    alone = row(f"{NAME}/{case}/trace", "Mitsuba, tracing alone / exact", measured, "Mitsuba", "exact", TRACING_BAR,
                "wall", picture=picture(scene), note=note)
    return [whole, alone.model_copy(update={"cpu": None})]


def least_resolution(scene: Scene) -> tuple[int, int]:
    """The coarsest mesh with at most MOST_WRONG wrong pixels, and how many it has. Raises UnsupportedError."""
    truth = render(scene, "exact")
    for resolution in RESOLUTIONS:
        other = _mesh(scene, resolution)
        wrong = int(np.sum((other.index != truth.index) & (truth.status != UNDECIDED)))
        if wrong <= MOST_WRONG:
            return resolution, wrong
    raise UnsupportedError(f"{scene.name}: no mesh up to resolution {RESOLUTIONS[-1]} has at most {MOST_WRONG} wrong "
                           f"pixels; the last has {wrong}")


def _mesh(scene: Scene, resolution: int) -> Picture:
    return render_with("mitsuba-mesh", scene, {"resolution": resolution, "repeat": False})
