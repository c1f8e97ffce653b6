"""Which pixels decide, and which are held back for the proof."""

from __future__ import annotations

import numpy as np


def deciding(scene_hash: str, height: int, width: int, attempt: int = 1) -> np.ndarray:
    """(height, width) bool: a random half of the pixels, the same whenever the same scene is planned."""
    random = np.random.default_rng([int(scene_hash[:16], 16), attempt])
    chosen = np.zeros(height * width, bool)
    chosen[random.permutation(height * width)[:(height * width + 1) // 2]] = True
    return chosen.reshape(height, width)
