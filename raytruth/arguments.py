"""What the commands' options share: kinds of values, and faults told in one sentence."""

from __future__ import annotations

import argparse
import math
from collections.abc import Callable
from pathlib import Path

MOST_DIGITS = 9  # of a whole number on the command line


class Parser(argparse.ArgumentParser):
    """Ends with one sentence and exit code 2, where argparse would print the whole usage before it."""

    def error(self, message: str):
        self.exit(2, f"raytruth: {sentence(message).removeprefix('argument ')}; '{self.prog} --help' tells more\n")


def sentence(text: object, longest: int = 300) -> str:
    """`text` in one printable line; words longer than `longest` characters, which only input has, are cut."""
    words = "".join(c if c.isprintable() else "?" if not c.isspace() else " " for c in str(text)).split()
    return " ".join(word if len(word) <= longest else word[:longest // 2] + "..." for word in words)


def size(text: str) -> tuple[int, int]:
    """WIDTHxHEIGHT, in pixels. What a picture may have is the scene format's to say."""
    width, _, height = text.partition("x")
    if not all(side.isascii() and side.isdigit() and len(side) <= MOST_DIGITS for side in (width, height)):
        raise argparse.ArgumentTypeError(f"{shown(text)} is not WIDTHxHEIGHT, e.g. 640x480")
    return int(width), int(height)


def whole(least: int, most: int = 10**MOST_DIGITS - 1) -> Callable[[str], int]:
    """The kind of an option that is a whole number from `least` to `most`."""
    def parse(text: str) -> int:
        digits = text.removeprefix("-")
        if not (digits.isascii() and digits.isdigit()):
            raise argparse.ArgumentTypeError(f"must be a whole number; found {shown(text)}")
        value = int(text) if len(digits) <= MOST_DIGITS else math.copysign(math.inf, -1 if text.startswith("-") else 1)
        return _within(value, least, most, text)

    return parse


def number(least: float, most: float) -> Callable[[str], float]:
    """The kind of an option that is a finite number from `least` to `most`."""
    def parse(text: str) -> float:
        try:
            value = float(text)
        except ValueError:
            value = math.nan
        if math.isnan(value):
            raise argparse.ArgumentTypeError(f"must be a number; found {shown(text)}")
        return _within(value, least, most, text)

    return parse


def _within(value, least, most, text):
    if not least <= value <= most:
        bound = f"at least {least:g}" if value < least else f"at most {most:.10g}"
        raise argparse.ArgumentTypeError(f"must be {bound}; found {shown(text)}")
    return value


def shown(text: str, longest: int = 60) -> str:
    """What was typed, fit to be shown in a sentence."""
    return repr(text if len(text) <= longest else text[:longest] + "...")


def resized(scene, size: tuple[int, int] | None):
    """`scene` at the size that --size asks for. Raises InputError."""
    from pydantic import ValidationError

    from raytruth.reference_tracer.errors import InputError
    from raytruth.reference_tracer.scene.load import one_line

    try:
        return scene.resized(*size) if size else scene
    except ValidationError as error:
        raise InputError(f"--size: {one_line(error)}") from None


def require_file(path: Path | None, *suffixes: str) -> None:
    """Raises InputError unless a file of such a suffix can be written to `path`: before the work, not after it."""
    from raytruth.reference_tracer.errors import InputError
    from raytruth.reference_tracer.writing import writable

    if path is None:
        return
    if path.suffix not in suffixes or not path.parent.is_dir():
        raise InputError(f"{path}: must end in {' or '.join(suffixes)} and lie in an existing folder")
    if path.is_dir() or not writable(path):
        raise InputError(f"{path}: cannot be written; choose another file")


def add_engine(parser, what: str, most: int = 1024) -> None:
    """The options that say where `what` is made: by how many processes here, or by a cluster."""
    parser.add_argument("--jobs", metavar="N", type=whole(1, most), default=2, help=f"{what} at the same time (default 2)")
    parser.add_argument("--cluster", metavar="ADDRESS", help="made by the workers of this Dask scheduler instead, e.g. "
                        "tcp://10.0.0.1:8786; they have to see the folder of results at the same path")


def seen_from(cluster: str | None, folder: Path) -> Path:
    """`folder` as the workers of a `cluster`, if there is one, can open it: they run elsewhere."""
    return folder.absolute() if cluster else folder


def require_folder(path: Path | None) -> None:
    """Raises InputError unless files can be written into the folder `path`, which may have to be made."""
    from raytruth.reference_tracer.errors import InputError
    from raytruth.reference_tracer.writing import writable

    if path is None:
        return
    try:
        there = next(p for p in (path, *path.absolute().parents) if p.exists())
    except (OSError, ValueError) as error:
        raise InputError(f"{path}: cannot be used as a folder ({getattr(error, 'strerror', None) or error})") from None
    if not there.is_dir():
        raise InputError(f"{path}: {there} is not a folder; choose another")
    if not writable(there):
        raise InputError(f"{path}: nothing can be written into {there}; choose another folder")
