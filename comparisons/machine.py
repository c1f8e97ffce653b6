"""What a measurement depends on: the machine, the packages, raytruth's own source."""

from __future__ import annotations

import hashlib
import os
import platform
import sys
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

import comparisons
import converters
import reference_tracer

from .results import Machine

PACKAGES = ("raytruth", "drjit", "mitsuba", "numpy", "trimesh", "embreex", "scikit-image", "OpenImageIO",
            "karellen-llvm-core")


def machine() -> Machine:
    return Machine(processor=_processor(), cores=len(os.sched_getaffinity(0)), memory_gib=round(_memory_gib(), 1),
                   system=f"{platform.system()} {platform.release()}", python=platform.python_version(),
                   packages=packages(), source=source_hash())


@cache
def packages() -> dict[str, str]:
    found = {}
    for name in PACKAGES:
        try:
            found[name] = version(name)
        except PackageNotFoundError:
            found[name] = "not installed"
    return found


@cache
def source_hash() -> str:
    """A hash of all code that can change a run: a cached run is reused only under the same code."""
    digest = hashlib.sha256(f"python {sys.version_info[:2]}".encode())
    for package in (reference_tracer, converters, comparisons):
        root = Path(package.__file__).parent
        for file in sorted(root.rglob("*.py")):
            digest.update(file.relative_to(root).as_posix().encode())
            digest.update(file.read_bytes())
    return digest.hexdigest()[:16]


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
