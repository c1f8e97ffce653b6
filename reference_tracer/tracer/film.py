"""The planes of a picture while it is rendered: only those that are wanted, filled band by band."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from .wavefront import DECIDED, NO_COLOR, Film, Primary

MISS, HIT, UNDECIDED = 0, 1, 2  # of the status plane
TYPES = {"color": np.float64, "t": np.float64, "position": np.float64, "normal": np.float64, "index": np.int32,
         "depth": np.uint8, "status": np.uint8}
PLANES = tuple(TYPES)
VECTORS = ("color", "position", "normal")
OF_HITS = ("t", "position", "normal", "index", "status")


class Planes:
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

    def store(self, where: slice | np.ndarray, light: Film, color_unit: float, samples: int,
              hits: Primary | None = None, object_count: int = 0) -> None:
        """Takes over what was traced for the pixels `where`; without `hits`, geometry planes stay as they are.

        A pixel one of whose colours is not finite has the colour NaN and is undecided.
        """
        count = len(self._arrays["color"][0, where]) if "color" in self._arrays else len(range(*where.indices(len(self))))
        numpy = lambda array: array.numpy()[..., :count]
        put = lambda name, value: self._arrays[name].__setitem__((..., where), value) if name in self._arrays else None
        doubt = numpy(light.doubt)
        if "color" in self._arrays:
            color = self._arrays["color"][:, where]  # a view, unless `where` lists pixels
            np.divide(numpy(light.color), samples**2 / color_unit, out=color)  # one rounding: the unit is a power of two
            if (lost := doubt == NO_COLOR).any():
                color[:, lost] = np.nan
            if not isinstance(where, slice):
                put("color", color)
        put("depth", numpy(light.generation))
        if hits is None:
            if "status" in self._arrays:
                status = self._arrays["status"]
                status[where] = np.where(doubt > DECIDED, UNDECIDED, status[where])
            return
        met = numpy(hits.index) < object_count
        put("t", numpy(hits.t))
        put("position", numpy(hits.point))
        put("normal", numpy(hits.normal))
        put("index", np.where(met, numpy(hits.index), -1))
        put("status", np.where(doubt > DECIDED, UNDECIDED, np.where(met, HIT, MISS)))
