"""One picture of all scenes, for the README: python -m raytruth.reports.figures.gallery RESULTS FILE.png"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
from skimage.transform import resize

from raytruth.comparisons.results import Results, read
from raytruth.reference_tracer.tracer.image_files import load_npz, to_8_bit, write_8_bit

COLUMNS, WIDTH, HEIGHT, GAP = 5, 240, 180, 6


def gallery(results: Results, folder: Path) -> np.ndarray:
    """The reference pictures of all scenes in rows of five, each scaled to fill its cell, (h, w, 3) uint8."""
    keys = {comparison.scene: comparison.reference for comparison in results.comparisons}
    cells = [_cell(load_npz(folder / results.run(keys[scene.name]).planes)[0]["color"]) for scene in results.scenes]
    rows = -(-len(cells) // COLUMNS)
    sheet = np.full((rows * (HEIGHT + GAP) - GAP, COLUMNS * (WIDTH + GAP) - GAP, 3), 255, np.uint8)
    for k, cell in enumerate(cells):
        top, left = k // COLUMNS * (HEIGHT + GAP), k % COLUMNS * (WIDTH + GAP)
        sheet[top:top + HEIGHT, left:left + WIDTH] = cell
    return sheet


def _cell(color: np.ndarray) -> np.ndarray:
    """`color` cut to the cell's shape about its middle and scaled down."""
    height, width = color.shape[:2]
    w, h = min(width, round(height * WIDTH / HEIGHT)), min(height, round(width * HEIGHT / WIDTH))
    top, left = (height - h) // 2, (width - w) // 2
    cut = np.clip(color[top:top + h, left:left + w], 0, 1)
    return to_8_bit(resize(cut, (HEIGHT, WIDTH), anti_aliasing=True))


if __name__ == "__main__":
    source, target = map(Path, sys.argv[1:3])
    write_8_bit(gallery(read(source), source), target)
