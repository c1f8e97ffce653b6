"""One run of POV-Ray 3.7: a process of its own in a folder of its own, under a time limit, without a shell."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from raytruth.reference_tracer.errors import MissingError, UnsupportedError

PROGRAM = "povray"
SECONDS = 280.0  # less than what the suite grants a run, so that POV-Ray's own delay is told as such
MOST_PIXELS = 1 << 27
LARGEST_HEADER = 200  # bytes


class PovrayError(RuntimeError):
    """POV-Ray failed, or what it left is not a picture; the text is one sentence."""


@dataclass(frozen=True)
class Shot:
    """A picture as POV-Ray wrote it."""

    pixels: np.ndarray  # (h, w, 3) big-endian uint16; 65535 stands for 1
    seconds: float  # of wall, from start to end of the process
    cpu: float  # seconds of all threads together, tracing alone
    version: str
    steep: dict[int, float]  # line of the text, from 1 on: the gradient found, above the max_gradient of its isosurface


def run(text: str, width: int, height: int, *, threads: int | None = None, seconds: float = SECONDS) -> Shot:
    """The picture of a scene in SDL, linear and with one sample per pixel.

    Raises MissingError without POV-Ray, UnsupportedError for too many pixels, and PovrayError for whatever goes wrong.
    """
    program = shutil.which(PROGRAM)
    if program is None:
        raise MissingError("POV-Ray is not installed; it is optional (Debian: apt-get install povray)")
    if width * height > MOST_PIXELS:
        raise UnsupportedError(f"{width} x {height} samples are more than one picture of POV-Ray may have here")
    with tempfile.TemporaryDirectory(prefix="raytruth-povray-") as name:
        folder = Path(name)
        (folder / "scene.pov").write_text(text, encoding="ascii")
        # settings of the user's own would change the picture: the folder is the process's home
        environment = {"PATH": os.environ.get("PATH", ""), "HOME": name, "LC_ALL": "C"}
        command = [program, "+Iscene.pov", "+Oscene.ppm", f"+W{width}", f"+H{height}", "+FP16", "File_Gamma=1.0", "-A",
                   "-D", "-P", f"+WT{threads or len(os.sched_getaffinity(0))}"]
        start = time.perf_counter()
        try:
            process = subprocess.run(command, cwd=folder, env=environment, stdin=subprocess.DEVNULL, timeout=seconds,
                                     stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)
        except subprocess.TimeoutExpired:
            raise PovrayError(f"POV-Ray gave no picture within {seconds:g} s") from None
        except OSError as error:
            raise PovrayError(f"POV-Ray cannot be started ({error.strerror})") from None
        elapsed = time.perf_counter() - start
        said = process.stderr.decode(errors="replace")
        if process.returncode:
            raise PovrayError(f"POV-Ray ended with exit code {process.returncode}{_complaint(said)}")
        pixels = _read(folder / "scene.ppm", width, height)
    cpu = re.search(r"Trace Time:[^\n]*\n?[^\n]*?with\s+([\d.]+) CPU-seconds", said)
    version = re.search(r"Version (3\.\d[\w.]*)", said)
    steep = {int(line): float(found) for line, found in re.findall(
        r"Line: (\d+)\s+Shutdown Warning: The maximum\s+gradient\s+found\s+was\s+([\d.]+),[^.]*\.\d+\.\s+"
        r"The\s+isosurface\s+may", said)}
    return Shot(pixels, elapsed, float(cpu[1]) if cpu else float("nan"), version[1] if version else "unknown", steep)


def _complaint(said: str) -> str:
    """The one line of POV-Ray's many that says what is wrong."""
    lines = [" ".join(line.split()) for line in said.splitlines() if line.strip()]
    errors = [line for line in lines if re.search(r"\b[Ee]rror\b", line)] or lines[-1:]
    return f": {errors[0][:300]}" if errors else ""


def _read(path: Path, width: int, height: int) -> np.ndarray:
    """The pixels of a binary PPM of 16 bits."""
    try:
        content = path.read_bytes()
    except OSError:
        raise PovrayError("POV-Ray ended well and left no picture") from None
    header = re.match(rb"P6\s+(?:#[^\n]*\n\s*)*(\d+)\s+(\d+)\s+(\d+)\s", content[:LARGEST_HEADER])
    if not header or header[3] != b"65535" or len(content) - header.end() != 6 * int(header[1]) * int(header[2]):
        raise PovrayError("POV-Ray left a file that is no picture of 16 bits")
    if (int(header[1]), int(header[2])) != (width, height):
        raise PovrayError(f"POV-Ray left a picture of {int(header[1])} x {int(header[2])} instead of {width} x {height}")
    return np.frombuffer(content, ">u2", offset=header.end()).reshape(height, width, 3)
