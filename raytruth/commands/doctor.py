"""Say what was found on this machine, and what to do about what was not."""

from __future__ import annotations

import contextlib
import json
import os
import re
import shutil
import signal
import subprocess
import sys
from dataclasses import asdict, dataclass

from raytruth.reference_tracer.text import hanging


def add_arguments(parser):
    parser.add_argument("--json", action="store_true", help="print the findings as JSON")


@dataclass
class Finding:
    """One thing raytruth uses: was it found, and what to do if not."""

    name: str
    found: bool
    detail: str
    remedy: str = ""
    required: bool = True


SECONDS, PROBE_SECONDS = 20, 120  # in which a program answers, and a library does its work

# Each probe runs in a process of its own: a wrong LLVM aborts the process that loads it.
_PROBE_LLVM = """
import ctypes, os; from raytruth import reference_tracer
library = ctypes.CDLL(os.environ["DRJIT_LIBLLVM_PATH"])
numbers = [ctypes.c_uint() for _ in range(3)]
library.LLVMGetVersion(*map(ctypes.byref, numbers))
import drjit as dr, drjit.llvm as arrays
x = dr.arange(arrays.Float64, 1000)
y = dr.minimum(dr.sqrt(x), 5) + dr.select(x > 3, dr.sin(x), x)
assert abs(y[4] - (2 + -0.7568024953079282)) < 1e-12
print(".".join(str(n.value) for n in numbers))
"""
_PROBE_MITSUBA = """
from raytruth import reference_tracer; import mitsuba
mitsuba.set_variant("llvm_ad_rgb")
scene = mitsuba.load_dict({"type": "scene", "ball": {"type": "sphere"}})
hit = scene.ray_intersect(mitsuba.Ray3f([0, 0, -3], [0, 0, 1]))
assert abs(hit.t[0] - 2) < 1e-5
print(mitsuba.__version__)
"""


def run(arguments) -> int:
    findings = [_python(), _drjit(), _llvm(), _threads(), _cuda(), _mitsuba(),
                _program("POV-Ray", ("povray",), "apt-get install povray", "an independent oracle of the whole model"),
                _raysect(),
                _program("Chromium", ("chromium", "chromium-browser", "google-chrome"), "apt-get install chromium",
                         "tests of the report in a real browser")]
    if arguments.json:
        print(json.dumps([asdict(f) for f in findings], indent=1))
    else:
        for f in findings:
            mark = "ok      " if f.found else "MISSING " if f.required else "absent  "
            print(hanging(f"{mark}{f.name:<10}", f.detail))
            if not f.found:
                print(hanging(f"{'':18}", f.remedy))
    return 0 if all(f.found or not f.required for f in findings) else 1


def _python() -> Finding:
    version = ".".join(map(str, sys.version_info[:3]))
    return Finding("Python", sys.version_info >= (3, 11), version, "use Python 3.11 or later")


def _drjit() -> Finding:
    from importlib.metadata import PackageNotFoundError, version

    try:
        return Finding("Dr.Jit", True, version("drjit"))
    except PackageNotFoundError:
        return Finding("Dr.Jit", False, "not installed", "pip install raytruth installs it")


def _llvm() -> Finding:
    from raytruth.reference_tracer import llvm  # importing it points Dr.Jit at a library unless the user did

    path = os.environ.get(llvm.VARIABLE)
    if not path:
        return Finding("LLVM", False, f"no libLLVM of version {llvm.OLDEST} or later", llvm.REMEDY)
    answer, problem = _probe(_PROBE_LLVM)
    origin = f"chosen by {llvm.VARIABLE}" if llvm.chosen_by_user else "found"
    if problem:
        return Finding("LLVM", False, f"{path} ({origin}): {problem}", llvm.REMEDY)
    if int(answer.split(".")[0]) < llvm.OLDEST:
        return Finding("LLVM", False, f"{answer}, {path} ({origin}): too old", llvm.REMEDY)
    return Finding("LLVM", True, f"{answer}, {path} ({origin})")


def _threads() -> Finding:
    return Finding("Threads", True, f"{len(os.sched_getaffinity(0))} cores for the LLVM thread pool")


def _cuda() -> Finding:
    found = shutil.which("nvidia-smi") is not None
    return Finding("CUDA", found, "a graphics card's driver is present (use --device cuda)" if found else "no graphics card",
                   "not needed: everything runs on the processor", required=False)


def _mitsuba() -> Finding:
    answer, problem = _probe(_PROBE_MITSUBA)
    return Finding("Mitsuba", not problem, problem or f"{answer}, variant llvm_ad_rgb works",
                   "pip install mitsuba; without it comparisons with Mitsuba are skipped")


def _raysect() -> Finding:
    from raytruth.comparisons.execution.code import installed

    version = installed("raysect")
    return Finding("raysect", version[0].isdigit(), version,
                   "optional, a third witness of geometry and shadows: pip install raysect", required=False)


def _program(name: str, names: tuple[str, ...], install: str, use: str) -> Finding:
    path = next((p for n in names if (p := shutil.which(n))), None)
    if path is None:
        return Finding(name, False, "not found", f"optional, {use}: {install}", required=False)
    try:
        _, said = _answer([path, "--version"], SECONDS)
    except subprocess.TimeoutExpired:
        return Finding(name, False, f"{path} gave no answer within {SECONDS} s", f"optional, {use}: {install}", required=False)
    except OSError as error:
        return Finding(name, False, f"{path} does not start ({error.strerror or error})", f"optional, {use}: {install}",
                       required=False)
    version = re.search(rf"^\s*(?:\S+ )?{re.escape(name)}(?: version)? (\d+(?:\.\w+)+)", said, re.MULTILINE | re.IGNORECASE) \
        or re.search(r"^\s*Google Chrome (\d+(?:\.\w+)+)", said, re.MULTILINE)
    if not version:
        return Finding(name, False, f"{path} does not say that it is {name}", f"optional, {use}: {install}", required=False)
    return Finding(name, True, f"{version[1]}, {path}", required=False)


def _answer(command: list[str], seconds: float) -> tuple[int, str]:
    """Exit code and all that `command` said, within a time. Whatever it started ends with it.

    Raises OSError and TimeoutExpired.
    """
    with subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                          start_new_session=True) as process:
        try:
            said, _ = process.communicate(timeout=seconds)
        finally:
            with contextlib.suppress(ProcessLookupError, PermissionError):
                os.killpg(process.pid, signal.SIGKILL)
    return process.returncode, said.decode(errors="replace")


def _probe(program: str) -> tuple[str, str | None]:
    """(last line printed, None), or ("", what went wrong)."""
    try:
        code, said = _answer([sys.executable, "-P", "-c", program], PROBE_SECONDS)
    except subprocess.TimeoutExpired:
        return "", f"gave no answer within {PROBE_SECONDS} s"
    last = ([line.strip() for line in said.splitlines() if line.strip()] or ["no message"])[-1]
    return ("", f"the probe ended with code {code} ({last[:120]})") if code else (last, None)
