"""Results kept by content: what a case needs is hashed to its key, and an equal key finds what was made of it.

A kind of result is a folder. KEY.json holds a record, under a line with checksums; KEY.npz, where there is one, the arrays
that belong to it. Every file appears in one step. What is truncated, altered or of another version is not found and so
made again; a failure is not kept, so that it is tried again.
"""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import TypeVar

import numpy as np
from pydantic import BaseModel

from raytruth.reference_tracer.writing import UnwritableError, atomically

from .code import code

Found = TypeVar("Found")


def key(*content, made_by: tuple[str, ...]) -> str:
    """A hash of all that can change a result: `content`, as JSON, and the code behind the modules `made_by`."""
    text = json.dumps([*content, code(*made_by)], sort_keys=True, allow_nan=True)
    return hashlib.sha256(text.encode()).hexdigest()[:24]


def require_folder(folder: Path) -> Path:
    """Makes `folder` if there is none, before the work and not after it. Raises UnwritableError."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise UnwritableError(f"{folder}: cannot be made ({error.strerror}); choose another folder") from None
    if not os.access(folder, os.W_OK | os.X_OK):
        raise UnwritableError(f"{folder}: cannot be written; choose another folder")
    return folder


class Store:
    """The results of one kind. `relative` names of arrays are those from the folder of all results."""

    def __init__(self, folder: Path, kind: str):
        """Raises UnwritableError."""
        self.kind, self.folder = kind, require_folder(folder / kind)

    def file(self, key: str) -> Path:
        """Where the arrays of `key` are, or where whoever makes them has to put them."""
        return self.folder / f"{key}.npz"

    def relative(self, key: str) -> str:
        return f"{self.kind}/{key}.npz"

    def find(self, key: str, read: Callable[[str], Found]) -> Found | None:
        """What `read` makes of the text kept under `key`; None if there is none that is whole, with its arrays."""
        try:
            head, body = (self.folder / f"{key}.json").read_text(encoding="utf-8").split("\n", 1)
            sums = json.loads(head)
            whole = sums["record"] == _checksum(body.encode()) and (
                sums["arrays"] is None or sums["arrays"] == _checksum_of(self.file(key)))
            return read(body) if whole else None
        except (OSError, ValueError, KeyError, TypeError, RecursionError):
            return None

    def keep(self, key: str, record: BaseModel | dict, arrays: bool = False) -> bool:
        """Keeps a record, with the arrays that were written to `file`; False where its state is not "ok": not kept."""
        body = json.dumps(record) if isinstance(record, dict) else record.model_dump_json()
        if json.loads(body).get("state", "ok") != "ok":
            return False
        sums = {"record": _checksum(body.encode()), "arrays": _checksum_of(self.file(key)) if arrays else None}
        with atomically(self.folder / f"{key}.json") as part:
            part.write_text(f"{json.dumps(sums)}\n{body}", encoding="utf-8")
        return True

    def arrays(self, key: str) -> dict[str, np.ndarray] | None:
        """The arrays kept under `key`; None if they are not whole."""
        return load(self.file(key)) if self.find(key, str) is not None else None

    def forget(self, key: str) -> None:
        """Removes whatever is left of `key`, parts of files included, so that it cannot pass for what is made now."""
        for leftover in (self.folder / f"{key}.json", self.file(key), *self.folder.glob(f".{key}.*.part*")):
            with suppress(OSError):
                leftover.unlink()


def save(path: Path, **arrays: np.ndarray) -> None:
    """Writes arrays into one file. Raises UnwritableError."""
    with atomically(path) as part, part.open("wb") as file:
        np.savez_compressed(file, **arrays)


def load(path: Path) -> dict[str, np.ndarray]:
    """The arrays of a file that `save` wrote. Raises OSError or ValueError."""
    with np.load(path, allow_pickle=False) as file:
        return {name: file[name] for name in file.files}


def _checksum(content: bytes) -> str:
    return hashlib.sha256(content).hexdigest()


def _checksum_of(path: Path) -> str:
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()
