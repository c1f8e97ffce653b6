"""Those who take turns, each on a scene."""

from __future__ import annotations

from pathlib import Path

from reference_tracer.render import render
from reference_tracer.scene import library
from reference_tracer.scene.model import Scene

from . import port
from .timing import Contestant, timed

THREADS = 2  # of the port and of the tracer, unless threads are what is measured

SINGLE = tuple(name for name in library.names() if library.scene(name).figure in {f"Figure {k}" for k in range(4, 10)})
RICH = tuple(name for name in library.names() if library.scene(name).figure in {f"Figure {k}" for k in range(10, 20)})


def tracer(name: str, scene: Scene, method: str, threads: int = THREADS) -> Contestant:
    return Contestant(name, lambda: timed(lambda: render(scene, method, threads=threads)))


def cpp_port(name: str, scene: Scene) -> Contestant:
    port.build()  # its compiler's time is not the port's
    return Contestant(name, lambda: port.render(scene, THREADS).cost, compiles=False)
