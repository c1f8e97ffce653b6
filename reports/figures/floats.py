"""The numbers of a picture as a script file, for the viewer: opened from disk, a page may load scripts and nothing else.

A file is `raytruth.planes(key, {...})`. A plane is an array of h rows, w columns and its channels, in the precision it has.
Its bits are taken as whole numbers, modulo 2^bits, in one of three ways, whichever is shortest: "plain", as they are; "near",
the difference of neighbours along a row, and of those along a column; "base", less the same plane of another side of the
scene, brought to the same type, with 0 in place of what is not a number. Differences d are written as 2 d, or -2 d - 1 below
zero: small ones then have leading zeros. All first bytes are written, the lowest, then all second ones, ...; each row by row,
its channels one after the other. This is deflated, and written 15 bits a character, from U+4000 on: in UTF-16, which a
browser knows by its first two bytes, that is a fifth less than base64. Normals are rounded to single precision, limits up to
eight bits of it; everything else is exact.
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
LEVEL = 6  # of zlib: 9 takes four times as long for less than a hundredth
ROWS = 4  # every fourth row tells which side is nearest


@dataclass(frozen=True)
class FloatFile:
    """A written file: relative to the report, its size in bytes, and whether colours have 64 or 32 bits."""

    file: str
    size: int
    bits: int
    base: str | None  # key of the side that has to be there before it is unpacked


def write(key: str, planes: Planes, known: dict[str, Planes], limit: np.ndarray | None, report: Path) -> FloatFile:
    """Writes the planes of the run `key`. `known` are other sides, by their keys, which it may be written against; `limit`
    (h, w) is how far a pixel's colour may be from the truth's."""
    height, width = planes.shape
    arrays = _arrays(planes) | ({"limit": _rounded_up(limit)} if limit is not None else {})
    sides = {side: _arrays(other) for side, other in known.items() if other.shape == planes.shape}
    nearest = min(sides, key=lambda side: _distance(arrays, sides[side]), default=None)
    packed = {name: _packed(array, sides[nearest].get(name) if sides else None) for name, array in arrays.items()}
    base = nearest if any(plane["way"] == "base" for plane in packed.values()) else None
    text = json.dumps({"width": width, "height": height, "base": base, "planes": packed}, separators=(",", ":"),
                      ensure_ascii=False)
    file = f"{FOLDER}/{slug(key)}.js"
    (report / FOLDER).mkdir(exist_ok=True)
    # JSON of ASCII: no character of a key ends the text, or the script
    script = f"raytruth.planes({json.dumps(key)},{text});\n"
    (report / file).write_bytes(codecs.BOM_UTF16_LE + script.encode("utf-16-le"))
    return FloatFile(file, (report / file).stat().st_size, 8 * arrays["color"].dtype.itemsize, base)


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
    kind, bits = f"{array.dtype.kind}{array.dtype.itemsize}", _bits(array)
    zero = bits.dtype.type(0)
    ways = {"plain": bits, "near": _small(np.diff(np.diff(bits, axis=0, prepend=zero), axis=1, prepend=zero))}
    if base is not None:
        ways["base"] = _small(bits - _bits(_as(base, array.dtype)))
    way, data = min(((way, _deflated(bits)) for way, bits in ways.items()), key=lambda found: len(found[1]))
    return {"type": kind, "way": way, "bytes": len(data), "data": _characters(data)}


def _bits(array: np.ndarray) -> np.ndarray:
    """(h, w, channels) whole numbers."""
    return np.ascontiguousarray(array).view(f"<u{array.dtype.itemsize}").reshape(*array.shape[:2], -1)


def _as(array: np.ndarray, kind: np.dtype) -> np.ndarray:
    with np.errstate(over="ignore"):
        return np.where(np.isnan(array), 0, array).astype(kind)


def _small(difference: np.ndarray) -> np.ndarray:
    """2 d or -2 d - 1 of a difference d of whole numbers, modulo 2^bits."""
    signed = difference.view(difference.dtype.str.replace("u", "i"))
    return ((signed << 1) ^ (signed >> (8 * signed.itemsize - 1))).view(difference.dtype)


def _distance(arrays: dict[str, np.ndarray], other: dict[str, np.ndarray]) -> float:
    """About how many bits two sides are apart."""
    return sum(np.log2(1.0 + _small(_bits(array[::ROWS]) - _bits(_as(other[name][::ROWS], array.dtype)))).sum()
               for name, array in arrays.items() if name in other)


def _characters(data: bytes) -> str:
    """15 bits a character, the last one filled up with zeros."""
    bits = np.unpackbits(np.frombuffer(data, np.uint8))
    groups = np.concatenate([bits, np.zeros(-len(bits) % 15, np.uint8)]).reshape(-1, 15)
    return (groups @ (1 << np.arange(14, -1, -1)) + FIRST).astype("<u2").tobytes().decode("utf-16-le")


def _deflated(bits: np.ndarray) -> bytes:
    by_byte = np.ascontiguousarray(bits).view(np.uint8).reshape(*bits.shape, -1)
    return zlib.compress(by_byte.transpose(3, 0, 2, 1).tobytes(), LEVEL)
