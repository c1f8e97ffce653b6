"""Section 2: the ray through every pixel."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from ..scene.model import Camera


@dataclass(frozen=True)
class Frame:
    """The camera of section 2 as numbers: v_pos, the unit vectors v_dir, v_x (right), v_y (up), and `ratio`."""

    v_pos: np.ndarray
    v_dir: np.ndarray
    v_x: np.ndarray
    v_y: np.ndarray
    ratio: float
    width: float
    height: float

    def mapped(self, number: Callable) -> Frame:
        """The same frame with its scalars as another number type."""
        return replace(self, ratio=number(self.ratio), width=number(self.width), height=number(self.height))


def frame(camera: Camera) -> Frame:
    """The frame of `camera` and the width of a pixel on the canvas at distance 1 (decisions C1, F5)."""
    v_dir, v_x, v_y = map(np.array, camera.axes)
    span = 2 * math.tan(math.pi * camera.fov / 360)
    return Frame(v_pos=np.array(camera.position), v_dir=v_dir, v_x=v_x, v_y=v_y,
                 ratio=span / max(camera.width, camera.height), width=camera.width, height=camera.height)


def canvas_point(f: Frame, row, col, sample_row, sample_col, samples: int):
    """(x, y) on the canvas of sample (sample_row, sample_col) of n x n in pixel (row, col), row 0 at the top (C2).

    One sample is the pixel's centre. Works on any array type.
    """
    x = f.ratio * ((col + (sample_col + 0.5) / samples) - f.width * 0.5)
    y = f.ratio * (-(row + (sample_row + 0.5) / samples) + f.height * 0.5)
    return x, y
