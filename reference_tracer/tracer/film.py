"""The planes of a picture while it is rendered: only those that are wanted, filled band by band."""

from __future__ import annotations

import math
from collections.abc import Sequence

import drjit as dr
import numpy as np

from .wavefront import DECIDED, NO_COLOR, Film, Primary

MISS, HIT, UNDECIDED = 0, 1, 2  # of the status plane
TYPES = {"color": np.float64, "t": np.float64, "position": np.float64, "normal": np.float64, "index": np.int32,
         "depth": np.uint8, "status": np.uint8}
PLANES = tuple(TYPES)
VECTORS = ("color", "position", "normal")
OF_HITS = ("t", "position", "normal", "index", "status")


class PlaneBuffer:
    """Arrays of all pixels in row order; those of vectors hold one plane a component, as kernels leave them."""

    def __init__(self, wanted: Sequence[str], height: int, width: int):
        self.shape = height, width
        self._arrays = {name: np.empty((3, height * width) if name in VECTORS else height * width, TYPES[name])
                        for name in dict.fromkeys(wanted)}

    def __len__(self) -> int:
        return self.shape[0] * self.shape[1]

    def __getitem__(self, name: str) -> np.ndarray:
        """The plane as (h, w) or (h, w, 3)."""
        array = self._arrays[name]
        return np.moveaxis(array.reshape(*array.shape[:-1], *self.shape), 0, -1) if name in VECTORS else \
            array.reshape(self.shape)

    @property
    def wants_hits(self) -> bool:
        return any(name in self._arrays for name in OF_HITS)

    def planes(self, names: Sequence[str]) -> dict[str, np.ndarray | None]:
        """Every plane of a picture; None where it is not among `names`."""
        return {name: self[name] if name in names else None for name in PLANES}

    def store(self, where: slice | np.ndarray, seen: dict) -> None:
        """Takes over what was `developed` of the pixels `where`; the planes that it lacks stay as they are."""
        for name in seen.keys() & self._arrays.keys():
            if isinstance(where, slice) and where == slice(0, len(self)):
                # Dr.Jit has had that memory before: fresh pages would cost more than a quick picture
                self._arrays[name] = seen[name].numpy()[..., :len(self)]
                continue
            count = len(range(*where.indices(len(self)))) if isinstance(where, slice) else len(where)
            rows, columns = (self._arrays[name], seen[name]) if name in VECTORS else ([self._arrays[name]], [seen[name]])
            for row, column in zip(rows, columns):
                row[where] = column.numpy()[:count]

    def mark_undecided(self, where: np.ndarray, seen: dict) -> None:
        """Of the pixels `where`, those that more samples leave in doubt; whether they are hit is known from their centres."""
        if "status" in self._arrays:
            self._arrays["status"][where[seen["doubt"].numpy()[:len(where)] > DECIDED]] = UNDECIDED


def developed(light: Film, hits: Primary | None, samples_per_unit, object_count) -> dict:
    """The planes of the pixels that were traced, as arrays of their final types; those of hits if there are `hits`.

    A colour is a sum in units of `World.color_unit`, divided by the number of samples (`samples_per_unit`, Float64). A pixel
    one of whose colours is not finite has the colour NaN and is undecided.
    """
    Float, UInt = type(samples_per_unit), type(light.doubt)
    double = lambda vector: dr.float64_array_t(vector)(vector)
    color = double(light.color) / samples_per_unit
    seen = {"color": dr.select(light.doubt == NO_COLOR, math.nan, color), "depth": dr.uint8_array_t(UInt)(light.generation),
            "doubt": light.doubt}
    if hits is not None:
        met = hits.index < object_count
        status = dr.select(light.doubt > DECIDED, UInt(UNDECIDED), dr.select(met, UInt(HIT), MISS))
        seen |= {"t": Float(hits.t), "position": double(hits.point), "normal": double(hits.normal),
                 "index": dr.select(met, dr.int32_array_t(UInt)(hits.index), -1), "status": dr.uint8_array_t(UInt)(status)}
    return seen
