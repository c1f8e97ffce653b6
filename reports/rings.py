"""Rings around single pixels: a picture shown at half its size would swallow them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from . import scale
from .colours import css
from .maps import Errors

MOST = 100  # of one kind; more than that are seen without help
WHITE = "#ffffff"


@dataclass(frozen=True)
class Ring:
    """Around the point (x, y), in pixels from the picture's upper left corner."""

    x: float
    y: float
    colour: str


def around_worst(worst: list[dict[str, float | int]], shape: tuple[int, int]) -> tuple[Ring, ...]:
    """Around the pixels that a comparison lists as its worst, as far as they lie in a picture of `shape`."""
    places = [(pixel.get("row", -1), pixel.get("col", -1)) for pixel in worst]
    height, width = shape
    return tuple(Ring(col + 0.5, row + 0.5, WHITE) for row, col in places if 0 <= row < height and 0 <= col < width)


def around_marks(errors: Errors) -> tuple[Ring, ...]:
    """Around pixels that see another object, and around undecided ones, each kind if it is rare."""
    rings = []
    for mask, colour in ((errors.mismatch & ~errors.undecided, scale.MISMATCH), (errors.undecided, scale.UNDECIDED)):
        places = np.argwhere(mask)
        if len(places) <= MOST:
            rings += [Ring(float(col) + 0.5, float(row) + 0.5, css(colour)) for row, col in places]
    return tuple(rings)
