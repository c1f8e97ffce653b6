"""The ground truth: a Whitted tracer of implicit surfaces f(x, y, z) = 0, vectorised with Dr.Jit in fp64."""

import os as _os

from . import llvm as _llvm

_llvm.choose()  # before anything of ours imports drjit; backend.py refuses what somebody else has loaded before
if _os.environ.get(_llvm.NARROW) == "1":
    _llvm.narrow_kernels()
