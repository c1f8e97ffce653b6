"""Is each limit tight? The next worse setting of a renderer must exceed it; a limit that lets that pass proves little.

A limit stands for all scenes, so it is the scene that comes closest to it that counts, on either side.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

from reference_tracer.scene.model import Scene

from ..gate import Tolerance, judge, tolerance_of
from ..results import Gate, Run
from ..runs import Request, RunStore
from .pairs import Pictures, measured
from .records import Tightness

TRUTH = "exact"
ALWAYS = ("not finite", "interior mismatches")  # limits of zero: nothing can be tighter


@dataclass(frozen=True)
class Worse:
    """The next worse setting of a renderer, against the truth."""

    renderer: str
    words: str
    settings: dict = field(default_factory=dict)


NEXT_WORSE = (
    Worse("mitsuba-mesh", "meshes of 128 cells instead of 256", {"resolution": 128}),
    Worse("embree", "meshes of 128 cells instead of 256", {"resolution": 128}),
)


def requests(scenes: Sequence[Scene], names: Sequence[str]) -> list[Request]:
    """The runs that the study needs beside those of the suite."""
    return [Request(scene, worse.renderer, worse.settings) for worse in NEXT_WORSE if worse.renderer in names
            for scene in scenes]


def tightness(scenes: Sequence[Scene], names: Sequence[str], runs: dict[str, Run], store: RunStore) -> list[Tightness]:
    """Every limit that a worse setting of a renderer in `names` tests."""
    return [row for worse in NEXT_WORSE if worse.renderer in names for row in _rows(worse, scenes, runs, store)]


def _rows(worse: Worse, scenes: Sequence[Scene], runs: dict[str, Run], store: RunStore) -> list[Tightness]:
    usual, coarser, tolerance = {}, {}, None
    for scene in scenes:
        truth, usual_run, worse_run = (runs[request.key] for request in (
            Request(scene, TRUTH), Request(scene, worse.renderer), Request(scene, worse.renderer, worse.settings)))
        if not truth.state == usual_run.state == worse_run.state == "ok":
            continue
        tolerance, pictures = tolerance_of(usual_run), Pictures(scene, store)
        usual[scene.name] = _gates(pictures, truth, usual_run, store, tolerance)
        coarser[scene.name] = _gates(pictures, truth, worse_run, store, tolerance)
    if tolerance is None:
        return []
    command = " ".join(["raytruth render", "{scene}", "--with", worse.renderer,
                        *(f"--set {k}={v}" for k, v in worse.settings.items())])
    rows = []
    for name in next(iter(usual.values())):
        if name in ALWAYS:
            continue
        scene, gate = max(((s, gates[name]) for s, gates in usual.items()), key=lambda item: _share(item[1]))
        worse_scene, worse_gate = max(((s, gates[name]) for s, gates in coarser.items()), key=lambda item: _share(item[1]))
        rows.append(Tightness(
            tolerance=tolerance.name, gate=name, limit=gate.limit, unit=gate.unit, scene=scene, share=_share(gate),
            worse=worse.words, worse_scene=worse_scene, worse_share=_share(worse_gate),
            verdict="tight" if _share(worse_gate) > 1 else "loose",
            command=command.format(scene=worse_scene) + " -o worse.npz"))
    return rows


def _gates(pictures: Pictures, truth: Run, test: Run, store: RunStore, tolerance: Tolerance) -> dict[str, Gate]:
    return {gate.name: gate for gate in judge(measured(pictures, truth, test, store), tolerance)[2]}


def _share(gate: Gate) -> float:
    """How much of its limit a gate's value takes up."""
    if gate.value is None:
        return 0.0
    return gate.value / gate.limit if gate.limit else (0.0 if gate.value == 0 else float("inf"))
