"""Sweeps of one parameter: does the error fall as theory says?"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from raytruth.reference_tracer.scene.model import Scene

from . import renderers
from .results import Run, Series
from .runs import Request
from .verdicts.pairs import Measurements, Pair

CURVED, MIRRORED = ("figure-05-sphere", "figure-07-torus", "figure-09-heart"), ("figure-reflection",)
MESH_RESOLUTIONS = (64, 128, 256, 512)
GRID_RESOLUTIONS = (32, 64, 128)
STEP_SIZES = (0.4, 0.2, 0.1, 0.05, 0.02, 0.01, 0.005, 0.001)
DOCUMENT_STEP, FINE_STEP = 0.1, 0.001
NONE = 0.5  # stands for "no pixel" on a logarithmic axis


class Study(Protocol):
    def requests(self) -> list[Request]:
        """The runs the study needs."""

    def pairs(self, runs: dict[str, Run]) -> list[Pair]:
        """Those of them that are held against each other."""

    def series(self, runs: dict[str, Run], measurements: Measurements) -> Series:
        """What they show."""


def planned(scenes: Sequence[Scene]) -> list[Study]:
    """The studies that the compared scenes allow."""
    curved = [s for s in scenes if s.name in CURVED]
    return [*ladders(scenes), StepLadder(curved)] if curved else []


@dataclass
class ResolutionLadder:
    """An error of Mitsuba against the cells along an object's longest side: meshes and grids err by O(h^2)."""

    id: str
    title: str
    y_label: str
    renderer: str
    resolutions: tuple[int, ...]
    scenes: list[Scene]
    error: str  # a metric
    band: tuple[float, float] = (-2.4, -1.6)  # where the slope must lie

    def requests(self):
        return [Request(s, "exact") for s in self.scenes] + [self._request(s, n) for s in self.scenes
                                                             for n in self.resolutions]

    def _request(self, scene: Scene, resolution: int) -> Request:
        usual = renderers.find(self.renderer).settings["resolution"]
        return Request(scene, self.renderer, {} if resolution == usual else {"resolution": resolution, "repeat": False})

    def _pair(self, scene: Scene, resolution: int, runs: dict[str, Run]) -> Pair | None:
        return _pair(scene, self._request(scene, resolution), runs, self.error.startswith("smooth"))

    def pairs(self, runs):
        return [pair for s in self.scenes for n in self.resolutions if (pair := self._pair(s, n, runs))]

    def series(self, runs, measurements):
        lines = {scene.title: [(float(n), error) for n in self.resolutions if (pair := self._pair(scene, n, runs))
                               and (error := measurements.of(pair).metrics.get(self.error))] for scene in self.scenes}
        slopes = _slopes(lines)
        holds = len(slopes) == len(self.scenes) and all(self.band[0] <= s <= self.band[1] for s in slopes.values())
        return Series(id=self.id, title=self.title, x_label="cells along the longest side", y_label=self.y_label,
                      lines=lines, expected="The error of a surface in pieces falls with the square of their size: "
                                            "slope -2.",
                      slope=slopes, holds=holds,
                      command=f"raytruth compare {' '.join(s.name for s in self.scenes)} --renderers {self.renderer}")


def _pair(scene: Scene, request: Request, runs: dict[str, Run], smooth: bool = False) -> Pair | None:
    """The truth and the run that was asked for, where there are both."""
    truth, test = runs[Request(scene, "exact").key], runs[request.key]
    return Pair(scene, truth, test, smooth) if truth.state == test.state == "ok" else None


def ladders(scenes: Sequence[Scene]) -> list[ResolutionLadder]:
    """Geometry of meshes and of grids on single surfaces; colours of meshes also where mirrors and shadows are."""
    curved = [s for s in scenes if s.name in CURVED]
    shaded = curved + [s for s in scenes if s.name in MIRRORED]
    away = "99th percentile, away from silhouettes"
    return [
        ResolutionLadder("mesh-ladder", "Depth error of meshes", f"relative depth error, {away}", "mitsuba-mesh",
                         MESH_RESOLUTIONS, curved, "depth p99"),
        ResolutionLadder("mesh-normals", "Normals of meshes", f"angle in degrees, {away}", "mitsuba-mesh",
                         MESH_RESOLUTIONS, curved, "normal p99 degrees"),
        ResolutionLadder("mesh-colors", "Colours of meshes", "colour error, 99th percentile, away from silhouettes, "
                         "those in mirrors too, and from shadows", "mitsuba-mesh", MESH_RESOLUTIONS, shaded,
                         "smooth color p99"),
        ResolutionLadder("grid-ladder", "Depth error of grids", f"relative depth error, {away}", "mitsuba-sdfgrid",
                         GRID_RESOLUTIONS, curved, "depth p99"),
        ResolutionLadder("grid-normals", "Normals of grids", f"angle in degrees, {away}", "mitsuba-sdfgrid",
                         GRID_RESOLUTIONS, curved, "normal p99 degrees")] if curved else []


@dataclass
class StepLadder:
    """Pixels on which the literal method sees another object than exact intersections, against its step size."""

    scenes: list[Scene]

    def requests(self):
        return [Request(s, "exact") for s in self.scenes] + [self._request(s, h) for s in self.scenes
                                                             for h in STEP_SIZES]

    @staticmethod
    def _request(scene: Scene, step_size: float) -> Request:
        return Request(scene, "paper", {"step_size": step_size, "repeat": False})

    def pairs(self, runs):
        return [pair for s in self.scenes for h in STEP_SIZES if (pair := _pair(s, self._request(s, h), runs))]

    def series(self, runs, measurements):
        lines = {}
        for scene in self.scenes:
            found = [(h, measurements.of(pair)) for h in STEP_SIZES
                     if (pair := _pair(scene, self._request(scene, h), runs))]
            lines[scene.title] = [(h, float(max(m.metrics["object mismatches"], NONE))) for h, m in found
                                  if m.state == "ok"]
        slopes = _slopes(lines, floor=NONE)
        wrong = [dict(points) for points in lines.values()]
        holds = all(len(w) == len(STEP_SIZES) and w[FINE_STEP] <= max(0.01 * w[DOCUMENT_STEP], NONE) for w in wrong)
        return Series(id="step-ladder", title="The literal method converges to the exact one", x_label="step size",
                      y_label=f"pixels that see another object ({NONE:g} stands for none)", lines=lines,
                      expected="A ray that cuts a chord shorter than the step may miss it. Chords shorter than h "
                               "belong to a rim of width proportional to h squared: slope 2 on average over where the "
                               "samples happen to fall. A hundredth of the document's step must leave at most a "
                               "hundredth of the wrong pixels.",
                      slope=slopes, holds=holds, command="raytruth compare figure-05-sphere figure-07-torus "
                                                         "figure-09-heart --renderers paper")


def _slopes(lines: dict[str, list[tuple[float, float]]], floor: float = 0.0) -> dict[str, float]:
    """Least-squares slopes in log-log of the points above `floor`, for lines of two such points or more."""
    slopes = {}
    for label, points in lines.items():
        above = np.log(np.array([(x, y) for x, y in points if y > floor]).reshape(-1, 2))
        if len(above) > 1:
            slopes[label] = round(float(np.polyfit(above[:, 0], above[:, 1], 1)[0]), 2)
    return slopes
