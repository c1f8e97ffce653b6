"""Studies of growth: what becomes of the time when one thing about a picture grows."""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Literal

from reference_tracer.errors import InputError
from reference_tracer.scene import library
from reference_tracer.scene.model import Camera, Light, Material, Object, Scene, Tracing
from reference_tracer.surfaces.expression import Expression
from reference_tracer.surfaces.plane import Plane
from reference_tracer.surfaces.sphere import Sphere

from ..bench.cases import spheres

Second = Literal["error", "efficiency", "memory", "rays", "evaluations"]

SECONDS = {"error": "mean error of colour against 1024 samples", "efficiency": "time of one thread / (threads × time)",
           "memory": "peak memory, MiB", "rays": "rays a pixel", "evaluations": "evaluations of f, a camera ray"}
REFERENCE_SAMPLES = 32  # of a side
BOTH = (("exact", {"method": "exact"}), ("paper", {"method": "paper"}))


@dataclass(frozen=True)
class Study:
    """`scene(x)` is what is rendered at x, by the methods of `lines` (label, settings)."""

    id: str
    title: str
    x_label: str
    values: tuple[float, ...]
    scene: Callable[[float], Scene]
    second: Second
    lines: tuple[tuple[str, dict], ...] = BOTH
    x_is_threads: bool = False
    remark: str = ""  # what the document says of it

    def reference(self) -> Scene | None:
        """What errors are taken against."""
        return self.scene(REFERENCE_SAMPLES**2) if self.second == "error" else None


def studies(full: bool) -> tuple[Study, ...]:
    """All studies; smaller pictures and fewer values unless `full`."""
    cores = len(os.sched_getaffinity(0))
    small, large = ((160, 120), (320, 240)) if not full else ((320, 240), (640, 480))
    sizes = (80, 160, 320, 640) + ((1280, 2560) if full else ())
    exact = BOTH[:1]
    return (
        Study("samples", "Samples a pixel", "samples a pixel", (1, 4, 9, 16, 64, 256), partial(_sampled, small),
              "error", exact, remark="the document sees no difference between 16 samples and 256"),
        Study("threads", "Threads", "threads", tuple(dict.fromkeys((*range(1, cores + 1), 2 * cores))),
              lambda threads: _sampled((640, 480), 16), "efficiency", exact, True,
              "the document reports four to five times the speed with 8 threads on 4 cores"),
        Study("resolution", "Pixels", "pixels", tuple(w * w * 3 // 4 for w in sizes), _resolved, "memory"),
        Study("objects", "Objects", "spheres", (10, 50, 200) + ((400, 800) if full else ()),
              lambda count: spheres(int(count), *small), "memory"),
        Study("depth", "Generations of secondary rays", "max_depth", (1, 2, 4, 8, 16, 32, 64),
              partial(_between_mirrors, small), "rays", exact),
        Study("distance", "Range of a ray", "max_distance", (7.5, 15.0, 30.0, 60.0, 120.0), partial(_reaching, large),
              "evaluations"),
    )


def _sampled(size: tuple[int, int], samples: float) -> Scene:
    return library.scene("figure-01-one-sample").resized(*size, samples=round(samples**0.5))


def _resolved(pixels: float) -> Scene:
    width = round((pixels * 4 / 3) ** 0.5)
    return library.scene("figure-07-torus").resized(width, width * 3 // 4, samples=1)


def _between_mirrors(size: tuple[int, int], depth: float) -> Scene:
    """A ball between two mirrors that face each other: a ray runs to and fro until its generations are used up."""
    wall = lambda z: Object(surface=Plane(center=(0.0, 0.0, z), a=0.0, b=0.0, c=1.0),
                            material=Material(color=(0.8, 0.9, 1.0), reflection=0.95))
    ball = Object(surface=Sphere(center=(0.5, -0.3, 3.0), r=0.5),
                  material=Material(color=(0.9, 0.4, 0.2), reflection=0.3))
    return Scene(name="between-mirrors", camera=Camera(width=size[0], height=size[1]),
                 objects=(wall(-1.0), wall(5.0), ball), lights=(Light(position=(2.0, 3.0, 1.0)),),
                 tracing=Tracing(max_depth=int(depth), max_distance=60.0))


def _reaching(size: tuple[int, int], distance: float) -> Scene:
    """A torus of whose extent nothing is known: no box ends a ray early."""
    torus = library.scene("figure-07-torus").resized(*size, samples=1).traced_with(max_distance=distance)
    old = torus.objects[0]
    p = old.surface.parameters
    formula = f"(x**2 + y**2 + z**2 + {p['R']!r}**2 - {p['r']!r}**2)**2 - 4 * {p['R']!r}**2 * (x**2 + y**2)"
    unbounded = Expression(type="expression", center=old.surface.center, formula=formula)
    return torus.model_copy(update={"objects": (old.model_copy(update={"surface": unbounded}),)})


def find(names: list[str], full: bool) -> tuple[Study, ...]:
    """The studies called `names`; all, if there are none. Raises InputError."""
    known = {study.id: study for study in studies(full)}
    for name in names:
        if name not in known:
            raise InputError(f"unknown study {name!r}; choose one of {', '.join(known)}")
    return tuple(known[name] for name in dict.fromkeys(names)) if names else tuple(known.values())
