"""Those who take turns, each on a scene."""

from __future__ import annotations

from reference_tracer.backend import use_threads
from reference_tracer.tracer.render import Renderer
from reference_tracer.scene import library
from reference_tracer.scene.model import Scene

from ..renderers import povray
from . import port
from .timing import Contestant, Cost, timed

PLANES = ("color", "index", "t")
THREADS = 2  # of the port and of the tracer, unless threads are what is measured

SINGLE = tuple(name for name in library.names() if library.scene(name).figure in {f"Figure {k}" for k in range(4, 10)})
RICH = tuple(name for name in library.names() if library.scene(name).figure in {f"Figure {k}" for k in range(10, 20)})


def tracer(name: str, scene: Scene, method: str, threads: int = THREADS) -> Contestant:
    """Ours, with the planes that the port makes; what its first picture records and compiles is not compared."""
    renderer = Renderer(scene, method, threads=threads)

    def run() -> Cost:
        use_threads(threads)  # they belong to the process, not to the renderer
        return timed(lambda: renderer.picture(PLANES))

    return Contestant(name, run)


def cpp_port(name: str, scene: Scene) -> Contestant:
    port.build()  # its compiler's time is not the port's
    return Contestant(name, lambda: port.render(scene, THREADS).cost, compiles=False)


def pov_ray(name: str, scene: Scene, **settings) -> Contestant:
    """Its wall time holds half a second of starting; its processor time is that of tracing alone."""
    def run() -> Cost:
        facts = povray.render(scene, planes=False, threads=THREADS, **settings).metadata
        return Cost(facts["first"], facts["cpu"])

    return Contestant(name, run, compiles=False)
