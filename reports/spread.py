"""How the errors of one map are spread over the scale: what its caption and its histogram say."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from . import scale
from .maps import Errors
from .scale import Swatch

BINS_A_DECADE = 4


@dataclass(frozen=True)
class Bar:
    """One bin of the histogram; all in percent of the drawing."""

    x: float
    width: float
    height: float


@dataclass(frozen=True)
class Spread:
    """Numbers of pixels; each pixel is counted once, as what `scale.paint` shows it."""

    pixels: int
    nothing: int  # equal, and neither side hits anything: a large empty background proves nothing
    equal: int  # equal, and something is hit
    marked: tuple[tuple[Swatch, int], ...]  # each mark outside the scale that occurs
    largest: float | None  # over the pixels without a mark; None if every pixel has one
    bars: tuple[Bar, ...]


def spread(error: np.ndarray, errors: Errors) -> Spread:
    """How one error plane of `errors` is spread."""
    non_finite = ~np.isfinite(error)
    undecided = errors.undecided & ~non_finite
    mismatch = errors.mismatch & ~undecided & ~non_finite
    measured = ~(non_finite | undecided | mismatch)
    equal = measured & (error == 0)
    marks = zip(scale.MARKS, (mismatch, undecided, non_finite))
    return Spread(error.size, int((equal & errors.nothing).sum()), int((equal & ~errors.nothing).sum()),
                  tuple((swatch, int(mask.sum())) for swatch, mask in marks if mask.any()),
                  float(error[measured].max()) if measured.any() else None, _bars(error[measured]))


def _bars(measured: np.ndarray) -> tuple[Bar, ...]:
    """Heights grow with the logarithm of the count, so that one pixel among a million is still seen."""
    bins = scale.DECADES * BINS_A_DECADE
    position = np.log10(np.clip(measured[measured > 0], scale.LOW, scale.HIGH) / scale.LOW) * BINS_A_DECADE
    counts = np.bincount(np.minimum(position.astype(int), bins - 1), minlength=bins)
    top = np.log1p(max(measured.size, 1))
    return tuple(Bar(100 * i / bins, 100 / bins, float(100 * np.log1p(n) / top)) for i, n in enumerate(counts) if n)
