"""How accurate a picture is: computed here, from its planes and the truth's."""

from __future__ import annotations

import numpy as np

from ..verdicts.metrics import VISIBLE, Planes, pixel_error
from .results import Accuracy, Uncertainty
from .truth import Truth

OTHER_ROOT = 0.01  # a depth that is off by more, relative to max(1, t), is that of another root
UNDECIDED = 2  # of the status plane


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
                    depth_p99=_quantile(depth[right]), depth_max=_largest(depth[right]),
                    color_p99=_quantile(color[decided & ~np.isnan(color)]),
                    color_max=_largest(color[decided & ~np.isnan(color)]),
                    undecided=int((planes["status"] == UNDECIDED).sum()))


def uncertainty(truth: Truth) -> Uncertainty:
    """How large an error may seem although there is none."""
    hit = truth.decided & (truth.index >= 0)
    depth, color = truth.t_bound[hit], truth.color_bound[truth.decided]
    return Uncertainty(depth_p99=_quantile(depth) or 0.0, depth_max=_largest(depth) or 0.0,
                       color_p99=_quantile(color) or 0.0, color_max=_largest(color) or 0.0)


def _quantile(values: np.ndarray) -> float | None:
    return float(np.quantile(values, 0.99)) if values.size else None


def _largest(values: np.ndarray) -> float | None:
    return float(values.max()) if values.size else None
