"""How the errors of one map are spread over the scale: what its caption and its histogram say."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from . import scale

BINS_A_DECADE = 4


@dataclass(frozen=True)
class Bar:
    """One bin of the histogram; all in percent of the drawing."""

    x: float
    width: float
    height: float


@dataclass(frozen=True)
class Spread:
    pixels: int
    equal: int
    mismatch: int
    undecided: int
    non_finite: int
    largest: float | None  # over the pixels that none of the marks above takes; None if there is no such pixel
    bars: tuple[Bar, ...]


def spread(error: np.ndarray, mismatch: np.ndarray, undecided: np.ndarray) -> Spread:
    """Counts pixels as `scale.paint` colours them, each once."""
    non_finite = ~np.isfinite(error)
    undecided = undecided & ~non_finite
    mismatch = mismatch & ~undecided & ~non_finite
    measured = error[~(non_finite | undecided | mismatch)]
    return Spread(error.size, int((measured == 0).sum()), int(mismatch.sum()), int(undecided.sum()),
                  int(non_finite.sum()), float(measured.max()) if measured.size else None, _bars(measured))


def _bars(measured: np.ndarray) -> tuple[Bar, ...]:
    """Heights grow with the logarithm of the count, so that one pixel among a million is still seen."""
    bins = scale.DECADES * BINS_A_DECADE
    position = np.log10(np.clip(measured[measured > 0], scale.LOW, scale.HIGH) / scale.LOW) * BINS_A_DECADE
    counts = np.bincount(np.minimum(position.astype(int), bins - 1), minlength=bins)
    top = np.log1p(max(measured.size, 1))
    return tuple(Bar(100 * i / bins, 100 / bins, float(100 * np.log1p(n) / top)) for i, n in enumerate(counts) if n)
