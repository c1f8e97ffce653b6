"""What every suite does alike: chooses cases by name, heads its document, reads what a worker answers."""

from __future__ import annotations

import time
from collections.abc import Callable, Collection, Mapping
from datetime import UTC, datetime
from typing import TypeVar

from pydantic import ValidationError

from raytruth.reference_tracer.errors import InputError

from .document import Record
from .execution.machine import machine
from .execution.pool import Task

T = TypeVar("T")
Answered = TypeVar("Answered", bound=Record)


def choose(names: Collection[str], known: Mapping[str, T], complaint: str) -> tuple[T, ...]:
    """What is called `names` in `known`, each once; all of it, if there are none. Raises InputError."""
    for name in names:
        if name not in known:
            raise InputError(f"{complaint} {name!r}; choose one of {', '.join(known)}")
    return tuple(known[name] for name in dict.fromkeys(names or known))


def head(start: float) -> dict:
    """When, how long and where a document was made; `start` is a time.monotonic()."""
    return {"created": datetime.now(UTC).isoformat(timespec="seconds"), "seconds": round(time.monotonic() - start, 1),
            "machine": machine()}


def reader(kind: type[Answered], what: str) -> Callable[[Task, dict], Answered]:
    """Reads the answer to a task as a record, which has a `state`; one that is no `what` is malformed."""
    def read(task: Task, answer: dict) -> Answered:
        try:
            return kind.model_validate(answer)
        except ValidationError:
            return kind(state="malformed", message=f"answered something that is no {what}")

    return read
