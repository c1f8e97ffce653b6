"""What is charted: on which scenes and surfaces, every method over a sweep of its own parameter; and studies of growth.

A new renderer or a new parameter is a row of SWEEPS.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial
from typing import Literal

from raytruth.reference_tracer.scene import library
from raytruth.reference_tracer.scene.model import Camera, Light, Material, Object, Scene, Tracing
from raytruth.reference_tracer.surfaces.expression import Expression
from raytruth.reference_tracer.surfaces.plane import Plane
from raytruth.reference_tracer.surfaces.sphere import Sphere

from .. import renderers
from ..bench.cases import spheres
from ..renderers import RENDERERS
from ..suites import choose

# --- subjects: the document's scenes, and single surfaces that are hard for one method or another ---------------------
BRIEF = ("figure-07-torus", "figure-09-heart", "figure-reflection", "surface-blob")
GOLDEN = "((1 + sqrt(5)) / 2) ** 2"
BALL = "(x**2 + y**2 + z**2 - 1)"

# name: title, formula, radius of the camera's distance
FORMULAS = {
    "surface-barth-sextic": (
        "Barth’s sextic: 65 double points",
        "4 * ({g} * x**2 - y**2) * ({g} * y**2 - z**2) * ({g} * z**2 - x**2) - (2 + sqrt(5)) * {b}**2", 3.2),
    "surface-thin-shell": ("A shell of thickness 0.01", "{b}**2 - 0.0001", 3.0),
    "surface-thinner-shell": ("A shell of thickness 0.001", "{b}**2 - 0.000001", 3.0),
    "surface-gyroid": ("Gyroid: no polynomial",
                       "sin(3*x)*cos(3*y) + sin(3*y)*cos(3*z) + sin(3*z)*cos(3*x)", 3.0),
    "surface-blob": ("Two melting balls: exponentials",
                     "0.3 - exp(-4 * ((x - 0.6)**2 + y**2 + z**2)) - exp(-4 * ((x + 0.6)**2 + y**2 + z**2))", 3.0),
}


@dataclass(frozen=True)
class Charted:
    """A scene at the size it is charted at, with one sample a pixel: every contestant traces the same rays."""

    scene: Scene
    kind: Literal["scene", "surface"]


def surface(name: str) -> Scene:
    """The single surface called `name` in front of a camera, lit by one light, with nothing known of its extent."""
    title, formula, distance = FORMULAS[name]
    return Scene(name=name, title=title, camera=Camera(position=(0.0, 0.0, -distance), fov=50.0),
                 objects=(Object(surface=Expression(type="expression", center=(0.0, 0.0, 0.0),
                                                    formula=formula.format(g=GOLDEN, b=BALL)),
                                 material=Material(color=(0.9, 0.7, 0.4))),),
                 lights=(Light(position=(3.0, 4.0, -6.0)),), tracing=Tracing(max_distance=2.0 * distance))


def chosen(names: list[str], full: bool, size: tuple[int, int]) -> list[Charted]:
    """The subjects called `names`, or paths of scene files; without names, a few or (`full`) all. Raises InputError."""
    names = names or ([*library.names(), *FORMULAS] if full else BRIEF)
    scenes = [surface(name) if name in FORMULAS else library.find(name) for name in dict.fromkeys(names)]
    return [Charted(s.resized(*size, samples=1), "surface" if len(s.objects) == 1 else "scene") for s in scenes]


# --- sweeps -----------------------------------------------------------------------------------------------------------
OURS = "reference"  # the process that runs our own first-hit methods


@dataclass(frozen=True)
class Contestant:
    """One point of a sweep: what a measuring process needs to know of it."""

    renderer: str  # OURS, or a name in RENDERERS
    settings: dict
    timed: dict = field(default_factory=dict)  # settings of timed runs only: what need not be made again

    @property
    def process(self) -> str:
        """Contestants of the same process name share a child process."""
        return OURS if self.renderer == OURS else renderers.find(self.renderer).module


@dataclass(frozen=True)
class Sweep:
    """A method over the `values` of its setting `key`; without a key it is a single point."""

    id: str
    method: str
    title: str
    kind: Literal["first hits", "converter", "control"]
    renderer: str
    settings: dict = field(default_factory=dict)
    key: str = ""
    parameter: str = ""
    values: tuple[float, ...] = ()
    brief: tuple[float, ...] = ()  # those of a short run
    timed: dict = field(default_factory=dict)

    @property
    def is_registered(self) -> bool:
        return self.renderer == OURS or self.renderer in RENDERERS

    def contestants(self, full: bool) -> list[tuple[float | None, Contestant]]:
        """Every value of the parameter with what is measured there."""
        if not self.key:
            return [(None, Contestant(self.renderer, self.settings, self.timed))]
        return [(value, Contestant(self.renderer, {**self.settings, self.key: value}, self.timed))
                for value in (self.values if full else self.brief)]

    def label(self, value: float | None) -> str:
        return "" if value is None else f"{self.parameter} {value:g}"


def _ours(id: str, title: str, method: str, precision: int = 64, group: str = "", **more) -> Sweep:
    settings = {"method": method, "precision": precision, **more.pop("settings", {})}
    return Sweep(id, group or method, title, "first hits", OURS, settings, **more)


STEPS = (0.5, 0.2, 0.1, 0.05, 0.02, 0.01, 0.005, 0.002, 0.001)
BRIEF_STEPS = (0.2, 0.1, 0.05, 0.02, 0.01, 0.005)
TOLERANCES = (1e-1, 1e-2, 1e-4, 1e-8, 1e-14)
RESOLUTIONS = (32, 64, 128, 256, 512)
BRIEF_RESOLUTIONS = (32, 64, 128)
ACCURACIES = (1e-2, 1e-3, 1e-4, 1e-6, 1e-8)

SWEEPS = (
    _ours("paper", "paper", "paper", key="step_size", parameter="step size", values=STEPS, brief=BRIEF_STEPS),
    _ours("paper-32", "paper, single precision", "paper", 32, key="step_size", parameter="step size", values=STEPS,
          brief=(0.1, 0.01)),
    _ours("paper-newton", "paper, step size 0.01", "paper", group="paper, Newton", settings={"step_size": 0.01},
          key="tolerance", parameter="Newton’s tolerance", values=TOLERANCES, brief=(1e-1, 1e-4)),
    _ours("descartes", "descartes", "descartes"),
    _ours("descartes-32", "descartes, single precision", "descartes", 32),
    _ours("interval", "interval", "interval"),
    _ours("interval-32", "interval, single precision", "interval", 32),
    _ours("exact", "exact", "exact"),
    _ours("exact-32", "exact, single precision", "exact", 32),
    _ours("proof", "proof", "proof"),
    Sweep("mitsuba-mesh", "Mitsuba, mesh", "Mitsuba, mesh", "converter", "mitsuba-mesh", {"repeat": False},
          "resolution", "resolution", RESOLUTIONS, BRIEF_RESOLUTIONS),
    Sweep("mitsuba-native", "Mitsuba, mesh", "Mitsuba, native shapes", "converter", "mitsuba-native",
          {"shapes": "native", "repeat": False}),
    Sweep("mitsuba-sdfgrid", "Mitsuba, grid", "Mitsuba, grid of distances", "converter", "mitsuba-sdfgrid",
          {"repeat": False}, "resolution", "resolution", RESOLUTIONS[:4], (32, 64)),
    Sweep("embree", "Embree", "Embree, mesh", "converter", "embree", {}, "resolution", "resolution", RESOLUTIONS,
          (32, 128)),
    Sweep("povray-isosurface", "POV-Ray", "POV-Ray, isosurface", "converter", "povray", {"shapes": "isosurface"},
          "accuracy", "accuracy", ACCURACIES, (1e-3, 1e-6), {"planes": False}),
    Sweep("povray-native", "POV-Ray", "POV-Ray, native shapes", "converter", "povray", {"shapes": "native"},
          timed={"planes": False}),
    Sweep("crude", "crude control", "crude control: one sample a ray", "control", OURS,
          {"method": "crude", "precision": 64}),
    Sweep("oracle", "oracle control", "oracle control: hands the truth through", "control", OURS, {"method": "oracle"}),
)


# --- growth: what becomes of the time when one thing about a picture grows --------------------------------------------
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


def find_studies(names: list[str], full: bool) -> tuple[Study, ...]:
    """The studies called `names`; all, if there are none. Raises InputError."""
    return choose(names, {study.id: study for study in studies(full)}, "unknown study")
