"""The error between two pictures, and what the caption of its map says."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from . import scale
from .planes import Planes
from .scale import Swatch, from_oklch

GOLDEN_ANGLE = 137.508  # degrees; successive hues stay far apart however many there are
BINS_A_DECADE = 4


def object_colours(count: int) -> np.ndarray:
    """(count, 3) uint8: a colour for every object of a scene."""
    number = np.arange(count)
    return from_oklch(np.where(number % 2, 0.62, 0.76), 0.115, 250 + GOLDEN_ANGLE * number)


@dataclass(frozen=True)
class Errors:
    """How far two pictures are apart; every plane is (h, w). NaN: not finite in one of them."""

    color: np.ndarray  # largest difference of a linear channel
    nothing: np.ndarray  # bool: neither picture hits anything
    mismatch: np.ndarray  # bool: another object, or a hit in one picture only
    undecided: np.ndarray  # bool: undecided in one picture at least


def color_error(reference: np.ndarray, test: np.ndarray) -> np.ndarray:
    """(h, w): the largest difference of a linear channel; NaN where either is not finite."""
    with np.errstate(invalid="ignore"):
        error = np.abs(test.astype(float) - reference).max(-1)
    return np.where(np.isfinite(error), error, np.nan)


def errors(reference: Planes, test: Planes) -> Errors:
    return Errors(color_error(reference.color, test.color), ~reference.hit & ~test.hit, reference.index != test.index,
                  reference.undecided | test.undecided)


@dataclass(frozen=True)
class Bar:
    """One bin of the histogram; all in percent of the drawing."""

    x: float
    width: float
    height: float


@dataclass(frozen=True)
class Spread:
    """How the errors of one map are spread over the scale. Each pixel is counted once, as what `scale.paint` shows it."""

    pixels: int
    nothing: int  # equal, and neither picture hits anything: a large empty background proves nothing
    equal: int  # equal, and something is hit
    special: tuple[tuple[Swatch, int], ...]  # each colour outside the scale that occurs
    largest: float | None  # over all pixels where it is finite; None if it is nowhere
    largest_shown: float | None  # the same over those that have a colour of the scale, if that is less
    bars: tuple[Bar, ...]


def spread(error: np.ndarray, errors: Errors) -> Spread:
    """How one error plane of `errors` is spread."""
    non_finite = ~np.isfinite(error)
    undecided = errors.undecided & ~non_finite
    mismatch = errors.mismatch & ~undecided & ~non_finite
    measured = ~(non_finite | undecided | mismatch)
    equal = measured & (error == 0)
    special = zip(scale.SPECIAL, (mismatch, undecided, non_finite))
    largest, shown = (float(error[mask].max()) if mask.any() else None for mask in (~non_finite, measured))
    return Spread(error.size, int((equal & errors.nothing).sum()), int((equal & ~errors.nothing).sum()),
                  tuple((swatch, int(mask.sum())) for swatch, mask in special if mask.any()),
                  largest, None if shown == largest else shown, _bars(error[measured]))


def _bars(measured: np.ndarray) -> tuple[Bar, ...]:
    """Heights grow with the logarithm of the count, so that one pixel among a million is still seen."""
    bins = scale.DECADES * BINS_A_DECADE
    position = np.log10(np.clip(measured[measured > 0], scale.LOW, scale.HIGH) / scale.LOW) * BINS_A_DECADE
    counts = np.bincount(np.minimum(position.astype(int), bins - 1), minlength=bins)
    top = np.log1p(max(measured.size, 1))
    return tuple(Bar(100 * i / bins, 100 / bins, float(100 * np.log1p(n) / top)) for i, n in enumerate(counts) if n)


@dataclass(frozen=True)
class Ring:
    """Around the point (x, y), in pixels from the picture's upper left corner: at half its size a pixel is not seen."""

    x: float
    y: float
    colour: str


def around_worst(worst: list[dict[str, float | int]], shape: tuple[int, int]) -> tuple[Ring, ...]:
    """Around the pixels that a comparison lists as its worst, as far as they lie in a picture of `shape`."""
    places = [(pixel.get("row", -1), pixel.get("col", -1)) for pixel in worst]
    height, width = shape
    return tuple(Ring(col + 0.5, row + 0.5, "#ffffff") for row, col in places if 0 <= row < height and 0 <= col < width)
