"""Pictures on disk, through OpenImageIO: multi-channel float EXR, exact fp64 NPZ, 8-bit PNG."""

from __future__ import annotations

import json
import os
import zipfile
from importlib.metadata import version
from pathlib import Path

import numpy as np

from ..errors import InputError
from .film import PLANES
from .render import Picture

SUFFIXES = (".png", ".exr", ".npz")
ROWS = 256  # converted at a time


def metadata(picture: Picture) -> dict:
    """Where a picture comes from: scene hash, versions, parameters. Every file format carries it."""
    return {**picture.metadata, "raytruth": version("raytruth"),
            "tracing": picture.scene.tracing.model_dump(mode="json")}


def require_writable(path: Path) -> None:
    """Raises InputError unless a picture can be written to `path`: a known suffix, an existing folder, no folder itself."""
    if path.suffix.lower() not in SUFFIXES:
        raise InputError(f"{path}: the output must end in one of {', '.join(SUFFIXES)}")
    if not path.parent.is_dir():
        raise InputError(f"{path}: the folder {path.parent} does not exist; make it first")
    if path.is_dir() or not os.access(path if path.exists() else path.parent, os.W_OK):
        raise InputError(f"{path}: cannot be written; choose another file")


def planes_of(path: Path) -> tuple[str, ...]:
    """The planes that a file of this suffix holds, and the status, which is always told."""
    return ("color", "status") if path.suffix.lower() == ".png" else PLANES


def save(picture: Picture, path: str | Path) -> None:
    """Writes `picture` in the format its suffix names; a failed write leaves no file. Raises InputError."""
    path = Path(path)
    require_writable(path)
    writer = {".png": save_png, ".exr": save_exr, ".npz": save_npz}[path.suffix.lower()]
    part = path.with_name(f".{path.stem}.part{path.suffix}")
    try:
        writer(picture, part)
        os.replace(part, path)
    except OSError as error:
        raise InputError(f"{path}: cannot be written ({error.strerror or error})") from None
    finally:
        part.unlink(missing_ok=True)


def to_8_bit(color: np.ndarray) -> np.ndarray:
    """Linear values to 0..255: clamped to [0, 1] and rounded to nearest, no gamma (decision P1). NaN becomes 0."""
    pixels = np.empty(color.shape, np.uint8)
    for start in range(0, len(color), ROWS):  # a picture of 8K has no room for copies of its floats
        rows = np.nan_to_num(color[start:start + ROWS], nan=0.0, posinf=1.0, neginf=0.0)
        pixels[start:start + ROWS] = np.floor(np.clip(rows, 0, 1) * 255 + 0.5).astype(np.uint8)
    return pixels


def save_png(picture: Picture, path: Path) -> None:
    write_8_bit(to_8_bit(picture.color), path, metadata(picture))


def write_8_bit(pixels: np.ndarray, path: str | Path, about: dict | None = None) -> None:
    """Writes (h, w, 1 or 3) uint8 as PNG."""
    _write(np.ascontiguousarray(pixels), path, "uint8", [], about or {})


def save_exr(picture: Picture, path: Path) -> None:
    """All planes as float channels: R G B, Z (t), P.xyz, N.xyz, id, depth, status."""
    planes = [picture.color, picture.t, picture.position, picture.normal, picture.index, picture.depth, picture.status]
    channels = np.concatenate([p.reshape(*picture.t.shape, -1).astype(np.float32) for p in planes], axis=-1)
    names = ["R", "G", "B", "Z", "P.x", "P.y", "P.z", "N.x", "N.y", "N.z", "id", "depth", "status"]
    _write(channels, path, "float", names, metadata(picture))


def save_npz(picture: Picture, path: Path) -> None:
    """All planes in full precision, and the metadata as a JSON text; `load_npz` reads it back."""
    arrays = {"metadata": np.array(json.dumps(metadata(picture))), **{name: getattr(picture, name) for name in PLANES}}
    # what numpy.savez_compressed writes, at zlib's fastest level: three times as fast for a tenth more bytes
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED, compresslevel=1) as archive:
        for name, array in arrays.items():
            with archive.open(f"{name}.npy", "w", force_zip64=True) as file:
                np.lib.format.write_array(file, array, allow_pickle=False)


def load_npz(path: str | Path) -> tuple[dict[str, np.ndarray], dict]:
    """The planes and the metadata of a file written by `save_npz`."""
    with np.load(path, allow_pickle=False) as file:
        return {name: file[name] for name in PLANES}, json.loads(str(file["metadata"]))


def _write(pixels: np.ndarray, path, kind: str, names: list[str], about: dict) -> None:
    import OpenImageIO as oiio  # 0.1 s; only when a picture is written

    height, width, channels = pixels.shape
    spec = oiio.ImageSpec(width, height, channels, kind)
    if names:
        spec.channelnames = names
        spec.attribute("compression", "zip")
    else:
        spec.attribute("png:compressionLevel", 1)  # half the time for 4 % more bytes
    for key, value in about.items():
        spec.attribute(f"raytruth:{key}", value if isinstance(value, str) else json.dumps(value))
    output = oiio.ImageOutput.create(str(path))
    if output is None or not output.open(str(path), spec) or not output.write_image(np.ascontiguousarray(pixels)):
        message = output.geterror() if output else oiio.geterror()
        raise OSError(message.strip() or "the image writer failed")
    output.close()
