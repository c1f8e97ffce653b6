"""How long kernels take to compile: known from what has been recorded, before it is compiled.

`python -m raytruth.reference_tracer.tracer.compilation [SCENE METHOD]...` measures what an operation takes.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass

import drjit as dr

# Seconds that LLVM takes for a recorded operation: half of the least that the command above finds, 2.4e-4, and twice the
# most, 1.35e-3 in a kernel of 27,000 operations (nine kinds of surfaces, on a machine with other work)
OPERATION = (1.2e-4, 2.7e-3)
SCENES = (("figure-05-sphere", "exact"), ("figure-07-torus", "exact"), ("figure-07-torus", "paper"),
          ("figure-07-torus", "proof"), ("figure-17-scene1", "exact"))


@dataclass(frozen=True)
class Compilation:
    """What is about to be compiled."""

    kernels: int
    operations: int  # of all of them

    @property
    def seconds(self) -> tuple[float, float]:
        return self.operations * OPERATION[0], self.operations * OPERATION[1]


_listener: ContextVar[Callable[[Compilation], None] | None] = ContextVar("listener", default=None)


@contextmanager
def heard(listener: Callable[[Compilation], None]) -> Iterator[None]:
    """`listener` hears of kernels before they are compiled."""
    token = _listener.set(listener)
    try:
        yield
    finally:
        _listener.reset(token)


def announce(kernels: int, arrays) -> None:
    """Tells who listens that what has been recorded, and is about to be evaluated, makes `kernels` kernels like it."""
    if (listener := _listener.get()) is not None:
        # Dr.Jit numbers what is recorded: a new variable has the number of all that there are
        last = dr.arange(arrays.UInt, 3) + arrays.count(1)
        listener(Compilation(kernels, kernels * last.index))


def _measure() -> None:
    from ..scene.library import find
    from .compilation import heard  # not that of __main__
    from .render import Renderer

    given = sys.argv[1:]
    for name, method in [*zip(given[::2], given[1::2])] or SCENES:
        found = []
        with heard(found.append):
            renderer = Renderer(find(name).resized(8, 6), method)
            start = time.process_time()
            renderer.picture()
            seconds = time.process_time() - start
        print(f"{name} {method}: {found[0].kernels} kernels of {found[0].operations:,} operations, {seconds:.1f} s, "
              f"{seconds / found[0].operations:.1e} s an operation")


if __name__ == "__main__":
    _measure()
