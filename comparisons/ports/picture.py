"""A finished picture from a file that somebody else made: PNG, EXR, PFM, NPY or NPZ, to linear colours in row order.

Nothing in such a file is trusted: sizes are checked before anything is read, arrays of objects are never loaded.
"""

from __future__ import annotations

import math
import zipfile
import zlib
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from raytruth.reference_tracer.errors import InputError

SUFFIXES = (".png", ".exr", ".pfm", ".npy", ".npz")
MOST_PIXELS = 2**24
LONGEST_SIDE = 16384
MOST_BYTES = MOST_PIXELS * 64  # of a file, and of an array in it
# what the readers of files raise where one is incomplete or none
BROKEN = (OSError, ValueError, EOFError, zipfile.BadZipFile, zlib.error, KeyError, SyntaxError, NotImplementedError,
          RuntimeError)
NAMES = ("color", "colour", "rgb", "image", "picture")  # of the colours in an NPZ, else its only array of that shape


@dataclass(frozen=True)
class FinishedPicture:
    """`color` (h, w, 3) fp64 as the file says it, whole numbers divided by `levels`; row 0 is the top of the picture."""

    color: np.ndarray
    levels: int | None  # the largest whole number of the format, None of floats
    bits: int  # of a channel
    told: tuple[str, ...]  # what was done to read it, and what stands out

    @property
    def tolerance(self) -> float:
        """What writing the file may change of a colour, at most (at 1, where floats are rounded relative to it)."""
        if self.levels:
            return 0.5 / self.levels
        return {16: 2.0**-11, 32: 2.0**-24, 64: 0.0}[self.bits]


def read(path: Path) -> FinishedPicture:
    """Reads a picture. Raises InputError, in one sentence, for anything that is none."""
    suffix = path.suffix.lower()
    if suffix not in SUFFIXES:
        raise InputError(f"{path}: a picture must end in one of {', '.join(SUFFIXES)}")
    try:
        if not path.is_file():
            raise InputError(f"{path}: there is no such file")
        if path.stat().st_size > MOST_BYTES:
            raise InputError(f"{path}: has more than {MOST_BYTES >> 20} MiB; give a smaller picture")
        array, told = {".npy": _npy, ".npz": _npz, ".pfm": _pfm}.get(suffix, _image)(path)
    except InputError:
        raise
    except BROKEN as error:
        reason = getattr(error, "strerror", None) or str(error).strip().split("\n")[0] or "it is incomplete"
        raise InputError(f"{path}: cannot be read as {suffix[1:].upper()} ({reason})") from None
    return _interpreted(path, array, told)


def _interpreted(path: Path, array: np.ndarray, told: list[str]) -> FinishedPicture:
    if array.ndim == 2:
        array, told = array[..., None], [*told, "one channel: taken as grey"]
    if array.ndim == 3 and array.shape[0] in (3, 4) and array.shape[2] not in (1, 2, 3, 4):
        array, told = np.moveaxis(array, 0, -1), [*told, f"channels come first in its shape {array.shape}: moved to the end"]
    if array.ndim != 3 or array.shape[2] not in (1, 2, 3, 4):
        raise InputError(f"{path}: has the shape {array.shape}; a picture is (height, width, 3), as RGB")
    _require_size(path, array.shape[0], array.shape[1])
    kind = array.dtype
    if kind.kind not in "uif" or kind.itemsize > 8:
        raise InputError(f"{path}: holds numbers of type {kind}; give 8- or 16-bit whole numbers, or floats")
    if array.shape[2] in (2, 4):
        alpha = array[..., -1]
        full = 1 if kind.kind == "f" else np.iinfo(kind).max
        told.append("alpha is 1 everywhere: left out" if (alpha == full).all() else
                    f"alpha is below 1 in {int((alpha != full).sum())} pixels: left out, colours taken as they stand")
        array = array[..., :-1]
    if array.shape[2] == 1:
        array = np.repeat(array, 3, axis=2)
    if kind.kind in "ui":
        levels = 255 if array.max(initial=0) <= 255 and kind != np.uint16 else 65535
        if array.min(initial=0) < 0 or array.max(initial=0) > levels:
            raise InputError(f"{path}: holds whole numbers from {array.min()} to {array.max()}; a picture of whole numbers "
                             "runs from 0 to 255 or to 65535")
        return FinishedPicture(array.astype(float) / levels, levels, 8 if levels == 255 else 16, tuple(told))
    color = array.astype(float)
    bits, levels = 8 * kind.itemsize, None
    finite = color[np.isfinite(color)]
    if finite.size and finite.max(initial=0) > 4 and np.array_equal(finite, np.round(finite)) and finite.max() <= 255:
        color, levels, bits = color / 255, 255, 8
        told.append("floats that are whole numbers up to 255: divided by 255")
    elif finite.size and len(np.unique(finite)) > 2 and finite.min() >= 0 and finite.max() <= 1 \
            and np.abs(finite * 255 - np.round(finite * 255)).max() < 1e-4:
        color, levels, bits = np.round(color * 255) / 255, 255, 8
        told.append("floats, but only multiples of 1/255: quantised to 8 bits before they were written")
    return FinishedPicture(color, levels, bits, tuple(told))


def _require_size(path: Path, height: int, width: int) -> None:
    if not (1 <= height <= LONGEST_SIDE and 1 <= width <= LONGEST_SIDE) or height * width > MOST_PIXELS:
        raise InputError(f"{path}: says it has {width} x {height} pixels; between 1 and {MOST_PIXELS} can be checked, no side "
                         f"longer than {LONGEST_SIDE}")


def _require_whole(path: Path) -> None:
    """Raises ValueError unless a PNG has all its chunks: of a truncated one the library silently shows what is there."""
    size, kind = path.stat().st_size, b""
    with path.open("rb") as file:
        if file.read(8) != b"\x89PNG\r\n\x1a\n":
            raise ValueError("not a PNG")
        while kind != b"IEND":
            head = file.read(8)
            kind = head[4:]
            if len(head) < 8 or file.tell() + int.from_bytes(head[:4], "big") + 4 > size:
                raise ValueError("it is incomplete")
            file.seek(int.from_bytes(head[:4], "big") + 4, 1)


def _image(path: Path) -> tuple[np.ndarray, list[str]]:
    import OpenImageIO as oiio

    if path.suffix.lower() == ".png":
        _require_whole(path)
    file = oiio.ImageInput.open(str(path))
    if file is None:
        raise OSError(oiio.geterror().strip().split("\n")[0] or "not a picture")
    try:
        spec = file.spec()
        if spec.format.basetype not in (oiio.UINT8, oiio.UINT16, oiio.HALF, oiio.FLOAT, oiio.DOUBLE):
            raise InputError(f"{path}: holds numbers of type {spec.format}; give 8- or 16-bit whole numbers, or floats")
        _require_size(path, spec.height, spec.width)
        if spec.depth > 1 or spec.deep or spec.nchannels > 64:
            raise InputError(f"{path}: is no plain picture of at most 64 channels")
        names, told = list(spec.channelnames), []
        chosen = list(range(min(spec.nchannels, 4)))
        if {"R", "G", "B"} <= set(names):
            chosen = [names.index(c) for c in ("R", "G", "B", "A") if c in names]
            told += [f"{spec.nchannels} channels: R, G and B are taken"] if spec.nchannels > 4 else []
        pixels = file.read_image(0, 0, 0, spec.nchannels, spec.format)
        if pixels is None:
            raise OSError(file.geterror().strip().split("\n")[0] or "it is incomplete")
    finally:
        file.close()
    return np.asarray(pixels).reshape(spec.height, spec.width, spec.nchannels)[..., chosen], told


def _header(path: Path, file) -> None:
    """Raises InputError where an NPY stream says that it holds more than a picture, or objects; goes back to its start."""
    version = np.lib.format.read_magic(file)
    read = {(1, 0): np.lib.format.read_array_header_1_0, (2, 0): np.lib.format.read_array_header_2_0}.get(version)
    if read is None:
        raise ValueError(f"version {version} of the format")
    shape, _, kind = read(file)
    if kind.hasobject:
        raise InputError(f"{path}: holds Python objects, which are never loaded; save an array of numbers")
    if math.prod(shape) * kind.itemsize > MOST_BYTES:
        raise InputError(f"{path}: says it holds an array of shape {shape}; {MOST_PIXELS} pixels can be checked at most")


def _npy(path: Path) -> tuple[np.ndarray, list[str]]:
    with path.open("rb") as file:
        _header(path, file)
        file.seek(0)
        return np.lib.format.read_array(file, allow_pickle=False), []


def _npz(path: Path) -> tuple[np.ndarray, list[str]]:
    with zipfile.ZipFile(path) as archive:
        members = {i.filename.removesuffix(".npy"): i for i in archive.infolist()[:64] if i.filename.endswith(".npy")}
        if any(i.file_size > MOST_BYTES for i in members.values()):
            raise InputError(f"{path}: holds an array of more than {MOST_BYTES >> 20} MiB; give a smaller picture")
        name = next((n for n in NAMES if n in members), next(iter(members)) if len(members) == 1 else None)
        if name is None:
            raise InputError(f"{path}: holds {len(members)} arrays, none called {' or '.join(NAMES)}; name the picture 'color'")
        with archive.open(members[name]) as file:
            _header(path, file)
        with archive.open(members[name]) as file:
            told = [f"the array {name!r} is taken"] if len(members) > 1 else []
            return np.lib.format.read_array(file, allow_pickle=False), told


def _pfm(path: Path) -> tuple[np.ndarray, list[str]]:
    """Portable float map: rows from the bottom, as its format says; the sign of the scale is the byte order."""
    with path.open("rb") as file:
        words = []
        for line in (file.readline(100) for _ in range(8)):
            words += line.decode("ascii", "replace").split("#")[0].split()
            if len(words) >= 4:
                break
        if len(words) != 4 or words[0] not in ("PF", "Pf") or not all(w.isdigit() and len(w) < 7 for w in words[1:3]):
            raise ValueError("its head must be PF or Pf, width, height, scale")
        width, height, scale, channels = int(words[1]), int(words[2]), float(words[3]), 3 if words[0] == "PF" else 1
        _require_size(path, height, width)
        if not math.isfinite(scale) or scale == 0:
            raise ValueError("its scale is not a number other than 0")
        data = file.read(4 * channels * width * height + 1)
    if len(data) != 4 * channels * width * height:
        fault = "fewer" if len(data) < 4 * channels * width * height else "more"
        raise ValueError(f"{fault} bytes than {width} x {height} pixels take")
    array = np.frombuffer(data, "<f4" if scale < 0 else ">f4").reshape(height, width, channels)
    return array[::-1].astype(np.float32), ["rows from the bottom, as the format says: turned"]
