"""Sweeps of one parameter: does the error fall as theory says?"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from reference_tracer.scene.model import Scene

from . import metrics
from .results import Run, Series
from .runs import Request, RunStore

RESOLUTIONS = (32, 64, 128, 256)
STEP_SIZES = (0.4, 0.2, 0.1, 0.05, 0.02, 0.01, 0.005, 0.001)
DOCUMENT_STEP, FINE_STEP = 0.1, 0.001
NONE = 0.5  # stands for "no pixel" on a logarithmic axis


class Study(Protocol):
    def requests(self) -> list[Request]:
        """The runs the study needs."""

    def series(self, runs: dict[str, Run], store: RunStore) -> Series:
        """What they show."""


def planned(scenes: Sequence[Scene]) -> list[Study]:
    """The studies that the compared scenes allow."""
    curved = [s for s in scenes if s.name in ("figure-05-sphere", "figure-07-torus", "figure-09-heart")]
    return [MeshLadder(curved), StepLadder(curved)] if curved else []


@dataclass
class MeshLadder:
    """Depth error of meshes against their resolution: marching cubes with projected vertices errs by O(h^2)."""

    scenes: list[Scene]

    def requests(self):
        return [Request(s, "exact") for s in self.scenes] + [self._request(s, n) for s in self.scenes
                                                             for n in RESOLUTIONS]

    @staticmethod
    def _request(scene: Scene, resolution: int) -> Request:
        return Request(scene, "mitsuba-mesh", {} if resolution == 256 else {"resolution": resolution})

    def series(self, runs, store):
        lines = {}
        for scene in self.scenes:
            points = []
            for n in RESOLUTIONS:
                truth, test = runs[Request(scene, "exact").key], runs[self._request(scene, n).key]
                if truth.state == test.state == "ok":
                    error = metrics.geometry(store.planes(truth, scene), store.planes(test, scene))["depth p99"]
                    points.append((float(n), error))
            lines[scene.title] = [p for p in points if p[1]]
        slopes = _slopes(lines)
        holds = len(slopes) == len(self.scenes) and all(-2.4 <= s <= -1.6 for s in slopes.values())
        return Series(id="mesh-ladder", title="Depth error of meshes", x_label="cells along the longest side",
                      y_label="relative depth error, 99th percentile, away from silhouettes", lines=lines,
                      expected="The error of a triangle mesh falls with the square of its cell size: slope -2.",
                      slope=slopes, holds=holds, command="raytruth compare figure-05-sphere figure-07-torus "
                                                         "figure-09-heart --renderers mitsuba-mesh")


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

    def series(self, runs, store):
        lines = {}
        for scene in self.scenes:
            truth = runs[Request(scene, "exact").key]
            points = []
            for h in STEP_SIZES:
                test = runs[self._request(scene, h).key]
                if truth.state == test.state == "ok":
                    wrong = store.planes(truth, scene)["index"] != store.planes(test, scene)["index"]
                    points.append((h, float(max(wrong.sum(), NONE))))
            lines[scene.title] = points
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
