"""Documents: what a suite leaves behind, one versioned JSON file each, for reports and other programs to read."""

from __future__ import annotations

import json
from collections.abc import Callable, Collection, Hashable, Sequence
from pathlib import Path
from typing import TypeVar

from pydantic import BaseModel, ConfigDict, ValidationError

from raytruth.reference_tracer.errors import InputError

from .execution.store import atomically


class Record(BaseModel):
    """Base of everything in a document."""

    model_config = ConfigDict(extra="forbid", frozen=True, ser_json_inf_nan="constants")


Document = TypeVar("Document", bound=Record)


def write(document: Record, path: Path) -> Path:
    """Replaces the file `path` in one step, so that an interrupted write loses nothing. Raises UnwritableError."""
    with atomically(path) as part:
        part.write_text(document.model_dump_json(indent=1), encoding="utf-8")
    return path


def read(path: Path, kind: type[Document], command: str) -> Document:
    """The document in the file `path`, which `command` makes. Raises InputError in one line.

    `kind` must have a field `version`; a document of another version is refused.
    """
    what, expected = f"a {path.stem} document", kind.model_fields["version"].default
    try:
        text = path.read_text(encoding="utf-8")
        version = json.loads(text).get("version")
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror}); '{command}' makes it") from None
    except (ValueError, AttributeError, RecursionError):
        raise InputError(f"{path}: is not {what}; make it again with '{command}'") from None
    if version != expected:
        raise InputError(f"{path}: has version {version}, this raytruth reads {expected}; make it again with '{command}'")
    try:
        return kind.model_validate_json(text)
    except ValidationError as error:
        first = error.errors(include_url=False)[0]
        place = ".".join(map(str, first["loc"]))
        raise InputError(f"{path}: {place}: {first['msg']}; make it again with '{command}'") from None


def keep(document: Document, path: Path, command: str) -> Document:
    """Writes `document`, unless the file already holds the same one of an earlier time, which is returned.

    The fields `created` and `seconds` do not count.
    """
    times = {name: blank for name, blank in (("created", ""), ("seconds", 0)) if name in type(document).model_fields}
    # as texts: NaN, which a document may hold, is not equal to itself
    timeless = lambda found: found.model_copy(update=times).model_dump_json()
    earlier = found(path, type(document), command)
    if earlier is not None and timeless(earlier) == timeless(document):
        return earlier
    write(document, path)
    return document


def found(path: Path, kind: type[Document], command: str) -> Document | None:
    """The document in the file `path`; None if there is none that can be read."""
    try:
        return read(path, kind, command)
    except InputError:
        return None


def joined(earlier: Document | None, document: Document, rows: dict[str, Callable[[Record], Hashable]],
           replaced: Collection[Hashable] | None = None, same: Sequence[str] = ()) -> Document:
    """`document` with the rows of an `earlier` one that it does not replace: comparing one more scene drops no other.

    `rows` are the fields that hold rows, and what each row is about; what is replaced is what `document` has rows about,
    unless that is said. Documents that differ in the fields `same` are not joined.
    """
    if earlier is None or any(getattr(earlier, name) != getattr(document, name) for name in same):
        return document
    update = {}
    for field, about in rows.items():
        own = getattr(document, field)
        gone = {about(row) for row in own} if replaced is None else replaced
        update[field] = [row for row in getattr(earlier, field) if about(row) not in gone] + list(own)
    return document.model_copy(update=update)
