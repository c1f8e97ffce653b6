"""From starting the command to the first picture's file, as a user sees it, with and without compiling kernels."""

from __future__ import annotations

import os
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from reference_tracer.errors import InputError

from ..options import Options
from ..results import Row
from ..timing import Contestant, Cost, Measured, judged, spread, take_turns

NAME = "first-picture"
CASES = ("figure-05-sphere",)
SIZE = "640x480"
BARS = {"empty kernel cache": 3.0, "warm kernel cache": 1.2}  # seconds


def measure(case: str, options: Options) -> list[Row]:
    with tempfile.TemporaryDirectory(prefix="raytruth-") as folder:
        kept = Path(folder) / "kept"
        fresh = (Path(folder) / f"fresh-{k}" for k in range(options.turns))
        measured = take_turns([
            Contestant("empty kernel cache", lambda: _picture(case, next(fresh)), compiles=False),
            Contestant("warm kernel cache", lambda: _picture(case, kept))], options.turns, options.budget)
    return [_row(case, name, bar, measured) for name, bar in BARS.items()]


def _row(case: str, name: str, bar: float, measured: Measured) -> Row:
    costs = measured.costs[name]
    wall = spread([c.wall for c in costs])
    return judged(Row(key=f"{NAME}/{case}/{name.split()[0]}", what=f"process start to file, {name}", unit="s", bar=bar,
                      sense="<=", clock="wall", wall=wall, cpu=spread([c.cpu for c in costs]), value=wall.median,
                      turns=len(costs), others=round(measured.others, 3), picture=SIZE.replace("x", " x ")))


def _picture(case: str, kernels: Path) -> Cost:
    """One run of `raytruth render` whose kernels are cached in the folder `kernels`."""
    kernels.mkdir(exist_ok=True)
    command = [sys.executable, "-m", "raytruth", "render", case, "--size", SIZE,
               "-o", str(kernels / "picture.png")]
    start, before = time.perf_counter(), resource.getrusage(resource.RUSAGE_CHILDREN)
    done = subprocess.run(command, capture_output=True, text=True, env={**os.environ, "DRJIT_CACHE_DIR": str(kernels)})
    wall, after = time.perf_counter() - start, resource.getrusage(resource.RUSAGE_CHILDREN)
    if done.returncode:
        raise InputError(f"raytruth render failed: {(done.stderr.strip().splitlines() or ['no reason given'])[-1]}")
    return Cost(wall, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime)
