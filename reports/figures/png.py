"""Pictures as small files: of up to 256 colours, which maps have, a byte a pixel."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from PIL import Image


def write(pixels: np.ndarray, path: Path) -> None:
    """Writes (h, w, 3) uint8 as PNG."""
    colours, index = np.unique(pixels.reshape(-1, 3).astype(np.uint32) @ [1 << 16, 1 << 8, 1], return_inverse=True)
    image = Image.fromarray(np.ascontiguousarray(pixels))
    if len(colours) <= 256:
        image = Image.fromarray(index.reshape(pixels.shape[:2]).astype(np.uint8))
        image.putpalette((colours[:, None] >> [16, 8, 0] & 255).astype(np.uint8).tobytes())
    image.save(path, optimize=True)
