"""The numbers of a picture as a script file, for the viewer: opened from disk, a page may load scripts and nothing else.

A file is `raytruth.planes(key, {...})`. A plane is an array in row order, little-endian, in the precision it has; its bytes
are shuffled (the first byte of every number, then the second, ...), deflated, and written 15 bits a character, from U+4000
on: in UTF-16, which a browser knows by its first two bytes, that is a fifth less than base64. Where that is shorter, the
bits are first combined by exclusive or with those of the same plane of the scene's truth, `base`, brought to the same type,
with 0 in place of what is not a number: pictures that agree to 12 digits then differ in few bytes. Normals are rounded to
single precision, limits up to eight bits of it; everything else is exact.
"""

from __future__ import annotations

import codecs
import json
import zlib
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ..text.words import slug
from .planes import Planes

FOLDER = "planes"
FIRST = 0x4000  # of 2^15 characters that are neither surrogates nor anything special in a script
TYPES = {"f8": np.uint64, "f4": np.uint32, "i4": np.uint32, "i1": np.uint8, "u1": np.uint8}  # and integers as wide


@dataclass(frozen=True)
class FloatFile:
    """A written file: relative to the report, its size in bytes, and whether colours have 64 or 32 bits."""

    file: str
    size: int
    bits: int
    has_limit: bool


def write(key: str, planes: Planes, base: tuple[str, Planes] | None, limit: np.ndarray | None, report: Path) -> FloatFile:
    """Writes the planes of the run `key`. `base` is the truth that they are packed against, under its key; `limit` (h, w)
    is how far a pixel's colour may be from it."""
    height, width = planes.shape
    arrays = _arrays(planes) | ({"limit": _rounded_up(limit)} if limit is not None else {})
    known = _arrays(base[1]) if base and base[1].shape == planes.shape else {}
    packed = {name: _packed(array, known.get(name)) for name, array in arrays.items()}
    against = base[0] if base and any(plane["xor"] for plane in packed.values()) else None
    text = json.dumps({"width": width, "height": height, "base": against, "planes": packed}, separators=(",", ":"),
                      ensure_ascii=False)
    file = f"{FOLDER}/{slug(key)}.js"
    (report / FOLDER).mkdir(exist_ok=True)
    # JSON of ASCII: no character of a key ends the text, or the script
    script = f"raytruth.planes({json.dumps(key)},{text});\n"
    (report / file).write_bytes(codecs.BOM_UTF16_LE + script.encode("utf-16-le"))
    return FloatFile(file, (report / file).stat().st_size, 8 * arrays["color"].dtype.itemsize, limit is not None)


def _arrays(planes: Planes) -> dict[str, np.ndarray]:
    narrow = np.int8 if planes.index.max() <= np.iinfo(np.int8).max else np.int32
    with np.errstate(over="ignore"):
        normal = planes.normal.astype(np.float32)
    return {"color": _native(planes.color), "t": _native(planes.t), "normal": normal, "index": planes.index.astype(narrow),
            "status": planes.status.astype(np.uint8)}


def _native(array: np.ndarray) -> np.ndarray:
    """In single precision where that holds every value: what a renderer computed with 32 bits."""
    with np.errstate(over="ignore", invalid="ignore"):
        single = array.astype(np.float32)
        return single if np.array_equal(single.astype(np.float64), array, equal_nan=True) else array.astype(np.float64)


def _rounded_up(limit: np.ndarray) -> np.ndarray:
    """Numbers >= 0 in single precision with the first eight bits of their mantissas: half the room, 0.4 % more at most."""
    bits = np.ascontiguousarray(limit, np.float32).view(np.uint32)
    return np.where(np.isfinite(limit), (bits + 0x7FFF) & 0xFFFF8000, bits).astype(np.uint32).view(np.float32)


def _packed(array: np.ndarray, base: np.ndarray | None) -> dict:
    kind = f"{array.dtype.kind}{array.dtype.itemsize}"
    bits = np.ascontiguousarray(array, array.dtype.newbyteorder("<")).ravel().view(TYPES[kind])
    plain, xor = _deflated(bits), None
    if base is not None and array.dtype.kind == "f":
        with np.errstate(over="ignore"):
            known = np.where(np.isnan(base), 0, base).astype(array.dtype).ravel().view(TYPES[kind])
        xor = _deflated(bits ^ known)
    shorter = xor is not None and len(xor) < len(plain)
    data = xor if shorter else plain
    return {"type": kind, "xor": shorter, "bytes": len(data), "data": _characters(data)}


def _characters(data: bytes) -> str:
    """15 bits a character, the last one filled up with zeros."""
    bits = np.unpackbits(np.frombuffer(data, np.uint8))
    groups = np.concatenate([bits, np.zeros(-len(bits) % 15, np.uint8)]).reshape(-1, 15)
    return (groups @ (1 << np.arange(14, -1, -1)) + FIRST).astype("<u2").tobytes().decode("utf-16-le")


def _deflated(bits: np.ndarray) -> bytes:
    return zlib.compress(bits.view(np.uint8).reshape(len(bits), -1).T.tobytes(), 9)
