"""The machine that results are made on."""

from __future__ import annotations

import contextlib
import hashlib
import os
import platform
import sys
from functools import cache
from pathlib import Path

from pydantic import Field

from ..document import Record
from .code import OURS, ROOT, installed

PACKAGES = ("raytruth", "drjit", "mitsuba", "numpy", "trimesh", "embreex", "scikit-image", "OpenImageIO",
            "karellen-llvm-core")


class Machine(Record):
    """Where the runs were made."""

    processor: str
    cores: int
    memory_gib: float
    system: str
    python: str
    packages: dict[str, str] = Field(description="name of every package that can change a number: its version")
    source: str = Field(description="hash of raytruth's own source")


def machine() -> Machine:
    return Machine(processor=_processor(), cores=len(os.sched_getaffinity(0)), memory_gib=round(_memory_gib(), 1),
                   system=f"{platform.system()} {platform.release()}", python=platform.python_version(),
                   packages=packages(), source=source_hash())


def packages() -> dict[str, str]:
    return {name: installed(name) for name in PACKAGES}


@cache
def source_hash() -> str:
    """A hash of all code that results can come from; `code` tells which of it made one."""
    digest = hashlib.sha256(f"python {sys.version_info[:2]}".encode())
    for package in OURS:
        for file in sorted((ROOT / package).rglob("*.py")):
            digest.update(file.relative_to(ROOT).as_posix().encode() + file.read_bytes())
    return digest.hexdigest()[:16]


def peak_kib() -> int:
    """The most memory that was resident in this process alone since it began, or since `forget_peak`.

    The kernel's ru_maxrss would begin with what the parent held when it forked.
    """
    with open("/proc/self/status", encoding="ascii") as file:
        return next(int(line.split()[1]) for line in file if line.startswith("VmHWM"))


def forget_peak() -> None:
    """Lets the peak begin anew with what is resident now, where the kernel allows it."""
    with contextlib.suppress(OSError), open("/proc/self/clear_refs", "w", encoding="ascii") as file:
        file.write("5")


def _processor() -> str:
    try:
        for line in Path("/proc/cpuinfo").read_text().splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    except OSError:
        pass
    return platform.processor() or platform.machine()


def _memory_gib() -> float:
    try:
        return os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES") / 2**30
    except (ValueError, OSError):
        return 0.0
