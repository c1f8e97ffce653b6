"""The C++ port of the document under tests/ports/cpp: builds it, runs it, reads what it made."""

from __future__ import annotations

import atexit
import json
import os
import shutil
import subprocess
import tempfile
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np

from raytruth import comparisons
from raytruth.converters.plain import plain
from raytruth.reference_tracer.errors import InputError, MissingError
from raytruth.reference_tracer.scene.model import Scene

from .timing import Cost

SOURCE = Path(comparisons.__file__).parents[1] / "tests" / "ports" / "cpp" / "tracer.cpp"
FLAGS = ("-std=c++17", "-O3", "-march=native", "-pthread")
LONGEST = 3600.0  # seconds


@dataclass
class PortPicture:
    """Planes as those of `reference_tracer.tracer.render.Picture`; `cost` is that of rendering alone."""

    color: np.ndarray  # (h, w, 3) fp64
    index: np.ndarray  # (h, w) int32
    t: np.ndarray  # (h, w) fp64
    cost: Cost


@cache
def build() -> Path:
    """The port's program, compiled once a process. Raises MissingError without a compiler or the source."""
    if not SOURCE.exists():
        raise MissingError("the C++ port's source is not installed with the package; run from a checkout of raytruth")
    return compiled(SOURCE.read_text(encoding="utf-8"))


def compiled(source: str) -> Path:
    """A program from the text of a port, kept as long as the process. Raises MissingError without a compiler."""
    compiler = os.environ.get("CXX") or next(filter(shutil.which, ("g++", "c++", "clang++")), None)
    if compiler is None:
        raise MissingError("the C++ port needs a C++ compiler; install g++, or name one in CXX")
    folder = tempfile.mkdtemp(prefix="raytruth-port-")
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    program, text = Path(folder) / "tracer", Path(folder) / "tracer.cpp"
    text.write_text(source, encoding="utf-8")
    command = [*compiler.split(), *FLAGS, str(text), "-o", str(program)]
    try:
        made = subprocess.run(command, capture_output=True, text=True, timeout=300)
    except OSError as error:
        raise MissingError(f"the C++ compiler {compiler} cannot be run ({error.strerror})") from None
    if made.returncode:
        raise InputError(f"the C++ port does not compile: {(made.stderr.splitlines() or ['no reason given'])[0]}")
    return program


def render(scene: Scene, threads: int = 2) -> PortPicture:
    """The picture that the port makes of `scene`. Raises UnsupportedError for scenes beyond the document's."""
    program = build()
    with tempfile.TemporaryDirectory(prefix="raytruth-") as folder:
        text, raw = Path(folder) / "scene.txt", Path(folder) / "picture.raw"
        text.write_text(plain(scene), encoding="ascii")
        done = subprocess.run([program, text, raw, str(threads)], capture_output=True, text=True, timeout=LONGEST)
        if done.returncode:
            raise InputError(f"{scene.name}: the C++ port failed: {done.stderr.strip() or done.returncode}")
        said, planes = json.loads(done.stdout), raw.read_bytes()
    shape = scene.camera.height, scene.camera.width
    pixels = shape[0] * shape[1]
    block = lambda kind, size, offset: np.frombuffer(planes, kind, size, offset)
    return PortPicture(color=block(np.float64, 3 * pixels, 0).reshape(*shape, 3),
                       index=block(np.int32, pixels, 24 * pixels).reshape(shape),
                       t=block(np.float64, pixels, 28 * pixels).reshape(shape),
                       cost=Cost(said["seconds"], said["cpu_seconds"]))
