"""Meshes that outlast a process: each is made once for all renderers, and for scenes that differ in light and material."""

from __future__ import annotations

import json
from contextlib import suppress
from pathlib import Path

import numpy as np

from raytruth.converters.mesh import Mesh, convert

from .execution import store
from .execution.store import Store

FOLDER = "meshes"
MOST_BYTES = 1 << 31  # of a folder; a mesh of 256 cells has about 15 MB
ARRAYS = ("vertices", "faces", "normals")


def keep_in(results: Path) -> None:
    """Takes meshes from the folder of `results` and puts there what is made, for the rest of this process."""
    convert.shelf = MeshStore(results)


class MeshStore(Store):
    """The folder of meshes. Those that were made first go when there are too many."""

    def __init__(self, results: Path):
        super().__init__(results, FOLDER)

    def take(self, made_of: str) -> Mesh | None:
        """The mesh of what `mesh_object` calls it, if it is there."""
        key = self._key(made_of)
        try:
            if (told := self.find(key, json.loads)) is None:
                return None
            arrays = store.load(self.file(key))
            return Mesh(**{**told, **arrays, "faces": arrays["faces"].astype(np.int64)})
        except (OSError, ValueError, KeyError, TypeError):  # another process has removed it, or it is none of ours
            return None

    def put(self, made_of: str, mesh: Mesh) -> None:
        """Keeps `mesh`. Raises UnwritableError."""
        key, told = self._key(made_of), dict(vars(mesh))
        arrays = {name: told.pop(name) for name in ARRAYS}
        if len(mesh.vertices) < 2**31:
            arrays["faces"] = arrays["faces"].astype(np.int32)
        with store.atomically(self.file(key)) as part, part.open("wb") as file:
            np.savez(file, **arrays)
        self.keep(key, told, arrays=True)
        self._bound()

    @staticmethod
    def _key(made_of: str) -> str:
        return store.key(made_of, made_by=(convert.__name__,))

    def _bound(self) -> None:
        sizes = {}
        for file in self.folder.glob("*.npz"):
            with suppress(OSError):  # another process may have removed it
                sizes[file] = file.stat()
        total = sum(size.st_size for size in sizes.values())
        for file in sorted(sizes, key=lambda file: sizes[file].st_mtime):
            if total <= MOST_BYTES:
                return
            total -= sizes[file].st_size
            self.forget(file.stem)
