"""Section 5, no more than needed: which pixels deserve more than one sample."""

from __future__ import annotations

import numpy as np


def differing(color: np.ndarray, index: np.ndarray, threshold: float) -> np.ndarray:
    """Pixels that differ from one of their eight neighbours, in the object seen or in a channel by more than
    `threshold`. (h, w) bool, from the colours (h, w, 3) and objects (h, w) seen through the pixels' centres.
    """
    height, width = index.shape
    found = np.zeros((height, width), bool)
    for down, right in ((0, 1), (1, 0), (1, 1), (1, -1)):  # the other four are the same pairs seen from the other side
        here = slice(0, height - down), slice(max(0, -right), width - max(0, right))
        there = slice(down, height), slice(max(0, right), width - max(0, -right))
        apart = (index[here] != index[there]) | ~(np.abs(color[here] - color[there]).max(axis=-1) <= threshold)
        found[here] |= apart
        found[there] |= apart
    return found
