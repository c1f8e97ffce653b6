"""Finds an LLVM that Dr.Jit can use, before Dr.Jit looks for one itself.

Dr.Jit takes the system's libLLVM; versions below 16 abort the process on some of its kernels. The package
karellen-llvm-core carries a recent one. A path the user has set in DRJIT_LIBLLVM_PATH is never overridden.
"""

from __future__ import annotations

import os
import re
import sysconfig
from pathlib import Path

VARIABLE = "DRJIT_LIBLLVM_PATH"
OLDEST = 16
REMEDY = (f"install karellen-llvm-core (pip install karellen-llvm-core), or point {VARIABLE} at a libLLVM "
          f"of version {OLDEST} or later")


chosen_by_user = bool(os.environ.get(VARIABLE))


def choose() -> str | None:
    """Points Dr.Jit at a usable libLLVM unless the user chose one; returns its path, or None where there is none."""
    if not chosen_by_user:
        found = find()
        if found:
            os.environ[VARIABLE] = str(found)
    return os.environ.get(VARIABLE)


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
