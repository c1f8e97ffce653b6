"""Is each limit tight? The next worse setting of a renderer must exceed it; a limit that lets that pass proves little.

A limit stands for all scenes, so it is the scene that comes closest to it that counts, on either side.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass, field

from raytruth.reference_tracer.scene.model import Scene

from .. import renderers
from ..results import Gate, Run
from ..runs import Request
from ..verdicts.judge import judge
from ..verdicts.pairs import Measurements, Pair
from ..verdicts.tolerances import DOUBLE, GRID, MESH, NATIVE, ORACLE, TRACERS, Tolerance, between
from .records import Tightness

TRUTH = "exact"
MOST = {"depth p99", "color p99"}  # the gates that a tolerance sets; single pixels are held to what follows from a run itself
OWN_OFFSET = {"offset": 9e-5}  # of Mitsuba's own rays from the surface they leave, relative to 1 + its coordinates


@dataclass(frozen=True)
class Worse:
    """A setting that a limit must not let pass."""

    words: str
    renderer: str
    settings: dict = field(default_factory=dict)


@dataclass(frozen=True)
class Held:
    """A tolerance, a renderer that is held to it, against what, and what is worse than it, next worse first."""

    tolerance: Tolerance
    renderer: str
    worse: tuple[Worse, ...]
    against: str = TRUTH

    def among(self, names: Sequence[str]) -> bool:
        return self.all <= {TRUTH, *names}

    @property
    def all(self) -> set[str]:
        return {self.renderer, self.against, *(w.renderer for w in self.worse)}

    def requests(self, scene: Scene) -> list[Request]:
        """What it is held to, the renderer itself, and everything worse."""
        return [Request(scene, self.against), Request(scene, self.renderer),
                *(Request(scene, worse.renderer, worse.settings) for worse in self.worse)]

    def expressed(self, scenes: Sequence[Scene]) -> list[Scene]:
        """The scenes to be studied, as all of them can express them."""
        return [renderers.nearest(scene, *sorted(self.all)).scene for scene in _studied(scenes)]


TELLING = ("figure-05-sphere", "figure-07-torus", "figure-09-heart", "figure-17-scene1", "figure-18-scene2",
           "figure-reflection", "effect-mixing")
COARSE = Worse("meshes of 128 cells instead of 256", "mitsuba-mesh", {"resolution": 128})
STARTS = "rays that start 9e-5 off their surface, as Mitsuba’s own do, instead of 1e-7"
HELD = (
    Held(DOUBLE, "exact", (Worse("single precision instead of double", "exact", {"precision": 32}),)),
    Held(NATIVE, "mitsuba-native", (Worse(STARTS, "mitsuba-native", OWN_OFFSET),
                                    Worse("meshes of 256 cells instead of exact shapes", "mitsuba-mesh"))),
    Held(MESH, "mitsuba-mesh", (COARSE,)),
    Held(GRID, "mitsuba-sdfgrid", (Worse("grids of 64 cells instead of 128", "mitsuba-sdfgrid", {"resolution": 64}),)),
    Held(ORACLE, "povray", (Worse("isosurfaces of accuracy 1e-6 instead of primitives, or of 1e-8", "povray",
                                  {"shapes": "isosurface", "accuracy": 1e-6}),)),
    Held(TRACERS, "mitsuba-mesh", (Worse(STARTS, "mitsuba-mesh", OWN_OFFSET), COARSE), against="embree"),
)


def requests(scenes: Sequence[Scene], names: Sequence[str]) -> list[Request]:
    """The runs that the study needs."""
    return [request for held in HELD if held.among(names) for scene in held.expressed(scenes)
            for request in held.requests(scene)]


def tightness(scenes: Sequence[Scene], names: Sequence[str], runs: dict[str, Run],
              measurements: Measurements) -> list[Tightness]:
    """Every limit that something worse than a renderer in `names` tests."""
    return [row for held in HELD if held.among(names)
            for row in _rows(held, held.expressed(scenes), runs, measurements)]


def _studied(scenes: Sequence[Scene]) -> list[Scene]:
    """Those that come closest to limits, or all; more samples than one only blur what a limit has to see."""
    single = [scene for scene in scenes if scene.tracing.samples == 1]
    return [scene for scene in single if scene.name in TELLING] or single


@dataclass(frozen=True)
class _Case:
    scene: Scene
    gate: Gate
    worse: Worse | None = None

    @property
    def share(self) -> float:
        """How much of its limit the gate's value takes up."""
        value, limit = self.gate.value, self.gate.limit
        return 0.0 if not value else value / limit if limit else float("inf")


def pairs(scenes: Sequence[Scene], names: Sequence[str], runs: dict[str, Run]) -> list[Pair]:
    """What has to be measured for it."""
    return [pair for held in HELD if held.among(names) for scene in held.expressed(scenes)
            for pair in _pairs(held, scene, runs)]


def _pairs(held: Held, scene: Scene, runs: dict[str, Run]) -> list[Pair]:
    """The renderer, then everything worse, against what it is held to; none where one is missing, or where the scene is
    held to another tolerance: without native shapes, say."""
    base, *others = (runs[request.key] for request in held.requests(scene))
    if any(run.state != "ok" for run in (base, *others)) or between(base, others[0]) is not held.tolerance:
        return []
    return [Pair(scene, base, run) for run in others]


def _rows(held: Held, scenes: Sequence[Scene], runs: dict[str, Run], measurements: Measurements) -> list[Tightness]:
    """A row for every limit."""
    usual: dict[str, list[_Case]] = defaultdict(list)
    worsened: dict[str, list[_Case]] = defaultdict(list)
    for scene in scenes:
        found = [measurements.of(pair) for pair in _pairs(held, scene, runs)]
        if not found or any(m.state != "ok" for m in found):
            continue
        for gate in judge(found[0].metrics, held.tolerance, held.tolerance)[2]:
            usual[gate.name].append(_Case(scene, gate))
        for worse, m in zip(held.worse, found[1:]):
            for gate in judge(m.metrics, held.tolerance, held.tolerance)[2]:
                worsened[gate.name].append(_Case(scene, gate, worse))
    return [_row(held.tolerance, max(cases, key=lambda c: c.share), max(worsened[name], key=lambda c: c.share))
            for name, cases in usual.items() if name in MOST]


def _row(tolerance: Tolerance, usual: _Case, worst: _Case) -> Tightness:
    return Tightness(tolerance=tolerance.name, gate=usual.gate.name, limit=usual.gate.limit, unit=usual.gate.unit,
                     scene=usual.scene.name, share=usual.share, worse=worst.worse.words, worse_scene=worst.scene.name,
                     worse_share=worst.share, verdict="tight" if worst.share > 1 else "loose",
                     command=Request(worst.scene, worst.worse.renderer, worst.worse.settings).command)
