"""The truth of a scene: proven first hits, and how far rounding alone may move each pixel.

A pixel that rounding decides (a silhouette or a shadow's edge runs through its ray) judges nobody.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from reference_tracer.tracer.render import UNDECIDED, render
from reference_tracer.scene.model import Scene
from reference_tracer.tracer.sensitivity import SAFETY, UNIT, perturbed

from ..verdicts.metrics import VISIBLE, largest_around

METHOD = "proof"
TOLD = "interval arithmetic, outward rounded: what it says of a ray is a proof"
PROBES = 4
ROUNDING = 2.0**-52


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
