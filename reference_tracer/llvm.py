"""Finds an LLVM that Dr.Jit can use, before Dr.Jit looks for one itself.

Dr.Jit takes the system's libLLVM; versions below 16 abort the process on some of its kernels. The package
karellen-llvm-core carries a recent one. A path the user has set in DRJIT_LIBLLVM_PATH is never overridden.
"""

from __future__ import annotations

import ctypes
import os
import re
import sys
import sysconfig
from pathlib import Path

from .errors import InputError

VARIABLE = "DRJIT_LIBLLVM_PATH"
NARROW = "RAYTRUTH_NARROW_KERNELS"  # 1: as if `narrow_kernels` were called first; 0: as if nobody called it
LANES = 4  # fp64 numbers in a register of AVX
OLDEST = 16
REMEDY = (f"install karellen-llvm-core (pip install karellen-llvm-core), or point {VARIABLE} at a libLLVM "
          f"of version {OLDEST} or later")


chosen_by_user = bool(os.environ.get(VARIABLE))
too_late = "drjit" in sys.modules  # importing Dr.Jit loads LLVM, and nothing can make it load another one


def choose() -> str | None:
    """Points Dr.Jit at a usable libLLVM unless the user chose one; returns its path, or None where there is none."""
    if not chosen_by_user:
        found = find()
        if found:
            os.environ[VARIABLE] = str(found)
    return os.environ.get(VARIABLE)


def require() -> None:
    """Raises InputError unless Dr.Jit has loaded an LLVM whose kernels do not abort the process. Imports Dr.Jit."""
    if not os.environ.get(VARIABLE):
        raise InputError(f"no LLVM library of version {OLDEST} or later was found; {REMEDY}")
    import drjit as dr

    if not dr.has_backend(dr.JitBackend.LLVM):
        raise InputError(f"Dr.Jit cannot load the LLVM library {os.environ[VARIABLE]}; {REMEDY}" if not too_late else
                         "Dr.Jit was imported before raytruth and has found no LLVM library; import raytruth first")
    version = dr.detail.llvm_version()
    if version[0] < OLDEST:
        loaded = f"LLVM {'.'.join(map(str, version))}, whose kernels may abort the process"
        raise InputError(f"drjit or mitsuba was imported before raytruth and has loaded {loaded}; import raytruth first, or "
                         f"point {VARIABLE} at a libLLVM of version {OLDEST} or later" if too_late and not chosen_by_user
                         else f"{os.environ[VARIABLE]} is {loaded}; {REMEDY}")


def narrow_kernels() -> None:
    """Kernels of this process handle 4 rays at a time, in place of Dr.Jit's 8 or 16.

    For work in which each kernel sees few rays: those are compiled in about half the time and run by up to a fifth slower.
    Pictures in fp64 have the same bits; in fp32, where wide kernels divide by approximations, they may differ. To be called
    before the first kernel, for good. Without effect where NARROW is 0, and where Dr.Jit has no LLVM or hides these functions
    of its. Imports Dr.Jit.
    """
    if os.environ.get(NARROW) == "0":
        return
    import drjit as dr

    if not dr.has_backend(dr.JitBackend.LLVM):
        return
    library = next(Path(dr.__file__).parent.glob("libdrjit-core.*"), None)
    try:
        core = ctypes.CDLL(str(library))  # the one that is loaded
        width, cpu, features, set_target = (getattr(core, name) for name in (
            "_Z21jit_llvm_vector_widthv", "_Z19jit_llvm_target_cpuv", "_Z24jit_llvm_target_featuresv",
            "_Z19jit_llvm_set_targetPKcS0_j"))
    except (OSError, AttributeError):
        return
    cpu.restype = features.restype = ctypes.c_char_p
    if width() > LANES:
        set_target(cpu(), features(), LANES)


def find() -> Path | None:
    """The newest libLLVM >= 16 of this Python environment, else of the system."""
    for pattern_root, pattern in ((Path(sysconfig.get_path("data")) / "lib", "libLLVM*.so*"),
                                  (Path("/usr/lib"), "llvm-*/lib/libLLVM*.so*"),
                                  (Path("/usr/lib"), "*-linux-gnu/libLLVM*.so*")):
        usable = [(version, path) for path in pattern_root.glob(pattern)
                  if (version := _version_in_name(path)) and version >= OLDEST]
        if usable:
            return max(usable)[1]
    return None


def _version_in_name(path: Path) -> int | None:
    match = re.search(r"libLLVM(?:-|\.so\.)(\d+)", path.name)
    return int(match[1]) if match else None
