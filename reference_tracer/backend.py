"""The array types a render runs on: LLVM on the processor or CUDA, in double or single precision."""

from __future__ import annotations

import gc
import os
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from importlib import import_module

import drjit as dr

from . import llvm
from .errors import InputError


def recorded(step: Callable) -> Callable:
    """`step`, recorded once and replayed. No garbage is collected meanwhile: Dr.Jit ends the process where an array of another
    recording is destroyed while it records."""
    frozen = dr.freeze(step, warn_after=1 << 30)

    def call(*inputs):
        collects = gc.isenabled()
        gc.disable()
        try:
            return frozen(*inputs)
        finally:
            if collects:
                gc.enable()

    return call


@dataclass(frozen=True)
class Backend:
    """Dr.Jit array types of one device and precision."""

    device: str
    precision: int
    Float: type
    Vector: type
    UInt: type
    Bits: type
    Bool: type
    PCG32: type  # random numbers

    def constant(self, value: float):
        """A number that kernels read at run time, so that another value needs no recompilation."""
        return dr.opaque(self.Float, float(value))

    def count(self, value: int):
        """A whole number that kernels read at run time."""
        return dr.opaque(self.UInt, int(value))

    def vector(self, values):
        return self.Vector(*(self.constant(v) for v in values))


@cache
def backend(precision: int = 64, device: str = "llvm") -> Backend:
    """The array types for `precision` 64 (the truth) or 32 and `device` "llvm" or "cuda".

    Raises InputError where the device cannot be used.
    """
    if device == "llvm":
        llvm.require()
    if device == "cuda" and not dr.has_backend(dr.JitBackend.CUDA):
        raise InputError("no CUDA device was found; use --device llvm")
    arrays = import_module(f"drjit.{device}")
    return Backend(device, precision,
                   Float=getattr(arrays, f"Float{precision}"),
                   Vector=arrays.Array3f64 if precision == 64 else arrays.Array3f,
                   UInt=arrays.UInt32, Bits=arrays.UInt64, Bool=arrays.Bool, PCG32=arrays.PCG32)


def use_threads(count: int | None) -> int:
    """Sets the size of Dr.Jit's thread pool (None: all cores) and returns it. Dr.Jit shares rows of rays among them."""
    if count is not None and not 1 <= count <= 1024:
        raise InputError(f"threads must be between 1 and 1024; found {count}")
    chosen = count or len(os.sched_getaffinity(0))
    dr.set_thread_count(chosen)
    return chosen
