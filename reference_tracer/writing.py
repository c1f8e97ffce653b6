"""Files that appear whole or not at all; a place that takes none is told in one sentence. All that is kept is written so."""

from __future__ import annotations

import errno
import os
import tempfile
import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from .errors import InputError

# the place is at fault and nothing that is written there: no room, no right, no folder
UNWRITABLE = {errno.ENOSPC, errno.EDQUOT, errno.EROFS, errno.EACCES, errno.EPERM, errno.ENOTDIR, errno.EISDIR,
              errno.EEXIST, errno.ENAMETOOLONG}


class UnwritableError(InputError):
    """A folder or a file that cannot be written; the text says which and why."""


@contextmanager
def atomically(path: Path) -> Iterator[Path]:
    """A file to write to, which takes the place of `path` in one step if all goes well, and is gone if not.

    It ends as `path` does: writers choose a format by that. Raises UnwritableError where the place is at fault.
    """
    part = path.with_name(f".{path.stem}.{os.getpid()}-{threading.get_ident()}.part{path.suffix}")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        yield part
        os.replace(part, path)
    except OSError as error:
        if error.errno not in UNWRITABLE:
            raise
        raise UnwritableError(f"{path}: cannot be written ({error.strerror}); make room there, or choose another folder"
                              ) from None
    finally:
        with suppress(OSError):
            part.unlink()


def require_file(path: Path) -> None:
    """Raises InputError unless a file can be written to `path`, in a folder that exists: before the work, not after it."""
    if not path.parent.is_dir():
        raise InputError(f"{path}: the folder {path.parent} does not exist; make it first")
    if path.is_dir() or not writable(path):
        raise InputError(f"{path}: cannot be written; choose another file")


def writable(path: Path) -> bool:
    """Whether a file can be written to `path`, or into it where it is a folder: tried, since permissions do not tell of
    every file system."""
    try:
        if path.exists() and not path.is_dir():
            return os.access(path, os.W_OK)
        with tempfile.TemporaryFile(dir=path if path.is_dir() else path.parent):
            return True
    except (OSError, ValueError):
        return False
