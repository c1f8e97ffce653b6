"""Growth with the picture: memory of 7680 x 4320 pixels at 4 x 4 samples, and time a pixel at a sixteenth of it up."""

from __future__ import annotations

import json
import subprocess
import sys

from reference_tracer.errors import InputError

from ..options import Options
from ..results import Row
from ..timing import QUIET, Contestant, Cost, judged, spread, take_turns

NAME = "resolution"
CASES = ("figure-02-16-samples",)
SIZES = {(1920, 1080): 16, (3840, 2160): 4, (7680, 4320): 1}  # how many pictures make as many pixels as the largest
MEMORY_BAR, LINEAR_BAR = 3.0, 1.15  # GiB; slowest over fastest time a pixel


def measure(case: str, options: Options) -> list[Row]:
    samples = 1 if options.quick else 4
    peaks = {}

    def pictures(size, count) -> Cost:
        made = _child(case, *size, samples, count)
        peaks[size] = made["peak_gib"]
        return Cost(made["wall"], made["cpu"])

    measured = take_turns([Contestant(f"{w} x {h}", lambda size=(w, h), n=n: pictures(size, n), compiles=False)
                           for (w, h), n in SIZES.items()], 1, options.budget)
    clock = options.clock or ("wall" if measured.others < QUIET else "cpu")
    growth = {c: max(costs) / min(costs) for c in ("wall", "cpu")
              for costs in [[getattr(cost[0], c) for cost in measured.costs.values()]]}
    picture = f"{samples} x {samples} samples"
    return [
        judged(Row(key=f"{NAME}/{case}/memory", what="peak memory of a 7680 x 4320 picture and its file", unit="GiB",
                   bar=MEMORY_BAR, sense="<=", value=peaks[7680, 4320], turns=1, picture=picture)),
        judged(Row(key=f"{NAME}/{case}/time", what="slowest / fastest time a pixel, 1920 x 1080 to 7680 x 4320",
                   bar=LINEAR_BAR, sense="<=", clock=clock, wall=spread([growth["wall"]]), cpu=spread([growth["cpu"]]),
                   value=growth[clock], turns=1, others=round(measured.others, 3), seconds=measured.seconds(),
                   picture=picture))]


def _child(case: str, width: int, height: int, samples: int, count: int) -> dict:
    """What `comparisons.bench.pictures` says, run in a process of its own so that its peak memory is its own."""
    command = [sys.executable, "-m", "comparisons.bench.pictures", *map(str, (case, width, height, samples, count))]
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode:
        raise InputError(f"{case} at {width} x {height}: {(done.stderr.strip().splitlines() or ['was killed'])[-1]}")
    return json.loads(done.stdout)
