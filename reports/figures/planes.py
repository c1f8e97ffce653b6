"""A run's image planes, read and checked, so that a bad file costs its own case and nothing else."""

from __future__ import annotations

import zipfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from raytruth.comparisons.results import Run
from raytruth.reference_tracer.tracer.render import UNDECIDED

SHAPES = {"color": 3, "t": 0, "normal": 3, "index": 0, "status": 0}  # channels; 0: a plain (h, w) plane


class NoPlanes(Exception):
    """A run has no usable picture; the text says why, in one sentence."""


@dataclass(frozen=True)
class Planes:
    """What a report shows of a picture; see reference_tracer.tracer.render.Picture."""

    color: np.ndarray  # (h, w, 3) fp64, linear
    t: np.ndarray  # (h, w) fp64
    normal: np.ndarray  # (h, w, 3) fp64
    index: np.ndarray  # (h, w) int, -1: nothing hit
    status: np.ndarray  # (h, w) uint8

    @property
    def shape(self) -> tuple[int, int]:
        return self.t.shape

    @property
    def hit(self) -> np.ndarray:
        return self.index >= 0

    @property
    def undecided(self) -> np.ndarray:
        return self.status == UNDECIDED


def read(run: Run, folder: Path) -> Planes:
    """The planes of `run`, from `folder`. Raises NoPlanes."""
    if run.planes is None:
        raise NoPlanes("The run left no picture.")
    return Planes(**load(run.planes, folder, SHAPES))


def load(name: str, folder: Path, shapes: dict[str, int]) -> dict[str, np.ndarray]:
    """The arrays of the file `name` in `folder` that are called as `shapes` says, of one size. Raises NoPlanes."""
    folder = folder.resolve()
    path = (folder / name).resolve()
    if not path.is_relative_to(folder):
        raise NoPlanes(f"{name} lies outside the folder of the results and is not read.")
    try:
        with np.load(path, allow_pickle=False) as file:  # what no page shows stays packed
            arrays = {plane: file[plane] for plane in shapes}
    except FileNotFoundError:
        raise NoPlanes(f"{name} is missing from the folder of the results.") from None
    except (OSError, ValueError, KeyError, EOFError, zipfile.BadZipFile) as error:
        raise NoPlanes(f"{name} cannot be read ({error}).") from None
    flat = next(plane for plane, channels in shapes.items() if not channels)
    size = arrays[flat].shape
    if len(size) != 2 or 0 in size:
        raise NoPlanes(f"{name} holds no picture: plane {flat} has shape {size}.")
    for plane, channels in shapes.items():
        expected = (*size, channels) if channels else size
        if arrays[plane].shape != expected:
            raise NoPlanes(f"{name} holds no picture: plane {plane} has shape {arrays[plane].shape}, not {expected}.")
        if arrays[plane].dtype.kind not in "bfiu":
            raise NoPlanes(f"{name} holds no picture: plane {plane} does not hold numbers.")
    return arrays
