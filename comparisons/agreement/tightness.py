"""Is each limit tight? The next worse setting of a renderer must exceed it; a limit that lets that pass proves little.

A limit stands for all scenes, so it is the scene that comes closest to it that counts, on either side.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass, field

from reference_tracer.scene.model import Scene

from ..gate import Tolerance, between, judge
from ..results import Gate, Run
from ..runs import Request, RunStore
from .pairs import Pictures, measured
from .records import Tightness

TRUTH = "exact"
ALWAYS = {"not finite", "interior mismatches"}  # limits of zero: nothing can be tighter


@dataclass(frozen=True)
class Worse:
    """The next worse setting of a renderer, held against the truth or against another renderer."""

    renderer: str
    words: str
    settings: dict = field(default_factory=dict)
    against: str = TRUTH

    def among(self, names: Sequence[str]) -> bool:
        return {self.renderer, self.against} <= {TRUTH, *names}


OWN_OFFSET = {"offset": 9e-5}  # of Mitsuba's own rays from the surface they leave, relative to 1 + its coordinates
NEXT_WORSE = (
    Worse("exact", "single precision instead of double", {"precision": 32}),
    Worse("mitsuba-native", "rays that start 9e-5 off their surface, as Mitsuba's own do, instead of 1e-6", OWN_OFFSET),
    Worse("mitsuba-mesh", "meshes of 128 cells instead of 256", {"resolution": 128}),
    Worse("mitsuba-mesh", "rays that start 9e-5 off their surface, as Mitsuba's own do, instead of 1e-6", OWN_OFFSET,
          against="embree"),
)


def requests(scenes: Sequence[Scene], names: Sequence[str]) -> list[Request]:
    """The runs that the study needs beside those of the suite."""
    return [Request(scene, worse.renderer, worse.settings) for worse in NEXT_WORSE if worse.among(names)
            for scene in scenes]


def tightness(scenes: Sequence[Scene], names: Sequence[str], runs: dict[str, Run], store: RunStore) -> list[Tightness]:
    """Every limit that a worse setting of a renderer in `names` tests."""
    return [row for worse in NEXT_WORSE if worse.among(names) for row in _rows(worse, scenes, runs, store)]


def _rows(worse: Worse, scenes: Sequence[Scene], runs: dict[str, Run], store: RunStore) -> list[Tightness]:
    """The rows of the tolerance that most scenes are held to: a scene without native shapes, say, is of another."""
    usual, worsened = defaultdict(dict), defaultdict(dict)
    for scene in scenes:
        requested = (Request(scene, worse.against), Request(scene, worse.renderer),
                     Request(scene, worse.renderer, worse.settings))
        base, usual_run, worse_run = (runs[request.key] for request in requested)
        if base.state == usual_run.state == worse_run.state == "ok":
            tolerance, pictures = between(base, usual_run), Pictures(scene, store)
            usual[tolerance][scene.name] = _gates(pictures, base, usual_run, store, tolerance)
            worsened[tolerance][scene.name] = _gates(pictures, base, worse_run, store, tolerance)
    if not usual:
        return []
    tolerance = max(usual, key=lambda t: len(usual[t]))
    rows, by_name = [], {scene.name: scene for scene in scenes}
    for name in next(iter(usual[tolerance].values())).keys() - ALWAYS:
        (scene, gate), (worse_scene, worse_gate) = (
            max(((s, g[name]) for s, g in gates[tolerance].items()), key=lambda item: _share(item[1]))
            for gates in (usual, worsened))
        rows.append(Tightness(
            tolerance=tolerance.name, gate=name, limit=gate.limit, unit=gate.unit, scene=scene, share=_share(gate),
            worse=worse.words, worse_scene=worse_scene, worse_share=_share(worse_gate),
            verdict="tight" if _share(worse_gate) > 1 else "loose",
            command=Request(by_name[worse_scene], worse.renderer, worse.settings).command))
    return sorted(rows, key=lambda row: row.gate)


def _gates(pictures: Pictures, base: Run, test: Run, store: RunStore, tolerance: Tolerance) -> dict[str, Gate]:
    return {gate.name: gate for gate in judge(measured(pictures, base, test, store), tolerance)[2]}


def _share(gate: Gate) -> float:
    """How much of its limit a gate's value takes up."""
    if gate.value is None:
        return 0.0
    return gate.value / gate.limit if gate.limit else (0.0 if gate.value == 0 else float("inf"))
