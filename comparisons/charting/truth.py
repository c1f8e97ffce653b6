"""The truth of a scene: proven first hits, and how far rounding alone may move each pixel; how accurate a picture is.

A pixel that rounding decides (a silhouette or a shadow's edge runs through its ray) judges nobody.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from raytruth.reference_tracer.scene.model import Scene
from raytruth.reference_tracer.tracer.render import UNDECIDED, render
from raytruth.reference_tracer.tracer.sensitivity import SAFETY, UNIT, perturbed

from ..verdicts.metrics import VISIBLE, Planes, largest_around, pixel_error
from .document import Accuracy, Uncertainty

METHOD = "proof"
ABOUT = "interval arithmetic, outward rounded: what it says of a ray is a proof"
PROBES = 4
ROUNDING = 2.0**-52
OTHER_ROOT = 0.01  # a depth that is off by more, relative to max(1, t), is that of another root


@dataclass(frozen=True)
class Truth:
    """All planes (h, w), colours (h, w, 3)."""

    color: np.ndarray
    t: np.ndarray
    index: np.ndarray
    decided: np.ndarray  # bool: judges others
    undecided: int  # pixels that the proof leaves open
    color_bound: np.ndarray  # what moving every ray by a few units of rounding changes
    t_bound: np.ndarray  # the same of t, relative to max(1, t)


def make(scene: Scene) -> Truth:
    """Renders the proof, and a few pictures whose rays are moved at random by a few units of rounding."""
    proof = render(scene, METHOD)
    plain, _ = perturbed(scene, "exact", 0.0, seed=0)
    color, t, moved = np.zeros(proof.t.shape), np.zeros(proof.t.shape), plain.index != proof.index
    for k in range(PROBES):
        probe, _ = perturbed(scene, "exact", UNIT[64], seed=k + 1)
        color = np.fmax(color, np.abs(probe.color - plain.color).max(axis=-1))
        moved |= probe.index != plain.index
        with np.errstate(invalid="ignore"):
            t = np.fmax(t, np.abs(probe.t - plain.t) / np.maximum(1, plain.t))
    color = SAFETY * largest_around(color)
    undecided = proof.status == UNDECIDED
    decided = ~undecided & ~largest_around(moved) & (color <= VISIBLE)
    return Truth(proof.color, proof.t, proof.index, decided, int(undecided.sum()),
                 np.maximum(color, ROUNDING), np.maximum(SAFETY * np.nan_to_num(t), ROUNDING))


def of_arrays(arrays: dict[str, np.ndarray]) -> Truth:
    """The truth from the arrays of a file. Raises TypeError."""
    return Truth(**{**arrays, "undecided": int(arrays["undecided"])})


def accuracy(truth: Truth, planes: Planes) -> Accuracy:
    """The picture's `planes` (color, t, index, status) against the truth, over the pixels that it decides."""
    decided, same = truth.decided, planes["index"] == truth.index
    color = pixel_error(truth.color, planes["color"])
    with np.errstate(invalid="ignore"):
        depth = np.abs(planes["t"] - truth.t) / np.maximum(1, truth.t)
    hit = truth.index >= 0
    wrong = decided & (~same | (hit & ~(depth <= OTHER_ROOT)) | np.isnan(color))
    right = decided & ~wrong & hit
    return Accuracy(pixels=int(decided.sum()), wrong=int(wrong.sum()),
                    visible=int((decided & ~(color <= VISIBLE)).sum()),
                    depth_p99=_p99(depth[right]), depth_max=_largest(depth[right]),
                    color_p99=_p99(color[decided & ~np.isnan(color)]),
                    color_max=_largest(color[decided & ~np.isnan(color)]),
                    undecided=int((planes["status"] == UNDECIDED).sum()))


def uncertainty(truth: Truth) -> Uncertainty:
    """How large an error may seem although there is none."""
    hit = truth.decided & (truth.index >= 0)
    depth, color = truth.t_bound[hit], truth.color_bound[truth.decided]
    return Uncertainty(depth_p99=_p99(depth) or 0.0, depth_max=_largest(depth) or 0.0,
                       color_p99=_p99(color) or 0.0, color_max=_largest(color) or 0.0)


def _p99(values: np.ndarray) -> float | None:
    return float(np.quantile(values, 0.99)) if values.size else None


def _largest(values: np.ndarray) -> float | None:
    return float(values.max()) if values.size else None
