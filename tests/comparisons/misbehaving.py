"""A renderer that misbehaves, in as many ways as real ones do. Run as a program it is a worker that knows it."""

import ctypes
import io
import os
import signal
import subprocess
import sys
import time
import zipfile
from pathlib import Path

import numpy as np

from raytruth.reference_tracer.tracer.render import Picture
from raytruth.reference_tracer.tracer.render import render as trace

WAYS = {  # the state a run must get, and a word of its message
    "segfault": ("crashed", "SIGSEGV"),
    "null pointer": ("crashed", "SIGSEGV"),
    "abort": ("crashed", "SIGABRT"),
    "exit": ("crashed", "exit code 3"),
    "exit as if all were well": ("crashed", "exit code 0"),
    "exception": ("crashed", "ZeroDivisionError"),
    "hang": ("timeout", "gave no answer"),
    "hang with a child": ("timeout", "gave no answer"),
    "crash with a child": ("crashed", "SIGKILL"),
    "chatter": ("timeout", "gave no answer"),
    "chatter and crash": ("crashed", "SIGABRT; its last words: the end"),
    "fill the disk": ("crashed", "File too large"),
    "nothing": ("crashed", "AttributeError"),
    "no file": ("malformed", "left no planes"),
    "garbage": ("malformed", "cannot be read"),
    "empty file": ("malformed", "cannot be read"),
    "nan": ("malformed", "without one finite colour"),
    "wrong size": ("malformed", "5 x 3 instead of 24 x 16"),
    "wrong plane": ("malformed", "'normal'"),
    "wrong object": ("malformed", "objects 7 to 7"),
    "unpacks to much": ("malformed", "too large"),
}


def render(scene, *, way: str, note: str = "") -> Picture:
    """`note`, or the variable NOTE, is a file for the ids of processes that must not survive."""
    picture, note = trace(scene, "exact"), note or os.environ.get("NOTE", "")
    if "child" in way:
        # a grandchild as well; both ignore a polite request to end
        stubborn = "import os, signal, sys, time; signal.signal(signal.SIGTERM, signal.SIG_IGN); os.fork(); " \
                   "open(sys.argv[1], 'a').write(f'{os.getpid()}\\n'); time.sleep(120)"
        subprocess.Popen([sys.executable, "-c", stubborn, note])
        while not os.path.exists(note) or len(Path(note).read_text().split()) < 2:
            time.sleep(0.01)
    match way:
        case "segfault":
            os.kill(os.getpid(), signal.SIGSEGV)
        case "null pointer":
            ctypes.string_at(0)
        case "abort":
            os.abort()
        case "exit":
            os._exit(3)
        case "exit as if all were well":
            os._exit(0)
        case "exception":
            1 / 0
        case "hang" | "hang with a child":
            while True:
                pass
        case "crash with a child":
            os.kill(os.getpid(), signal.SIGKILL)
        case "chatter":
            while True:
                sys.stderr.write("x" * 65536)
        case "chatter and crash":
            for _ in range(400):
                sys.stderr.write("x" * 65536)
            sys.stderr.write("\nthe end\n")
            sys.stderr.flush()
            os.abort()
        case "fill the disk":
            with open(note, "wb") as file:
                file.truncate(1 << 40)
        case "nothing":
            return None
        case "no file" | "garbage" | "empty file" | "unpacks to much":
            _put_in_its_place(way)
        case "nan":
            picture.color[:] = np.nan
        case "dim":
            picture.color *= 0.9
        case "wrong size":
            return trace(scene.resized(5, 3), "exact")
        case "wrong plane":
            picture.normal = picture.normal[..., 0]
        case "wrong object":
            picture.index[:] = 7
    return picture


def _put_in_its_place(way: str) -> None:
    """What the worker is about to move to where it belongs, once, is something else."""
    move = os.replace

    def replaced(part, planes):
        os.replace = move
        Path(part).unlink()
        if way != "no file":
            Path(planes).write_bytes(_bytes(way))

    os.replace = replaced


def _bytes(way: str) -> bytes:
    if way != "unpacks to much":
        return b"" if way == "empty file" else b"PK\x03\x04" + bytes(range(256))
    file = io.BytesIO()
    with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("color.npy", bytes(1 << 24))
    return file.getvalue()


if __name__ == "__main__":
    from raytruth.comparisons import renderers
    from raytruth.comparisons.execution import worker

    sys.modules["raytruth.comparisons.renderers.misbehaving"] = sys.modules["__main__"]
    for known in (*WAYS, "dim"):
        renderers.RENDERERS[known] = renderers.Renderer(known, f"the renderer with {known}", "misbehaving", {"way": known})
    worker.main()
