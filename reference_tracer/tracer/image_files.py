"""Pictures on disk, through OpenImageIO: multi-channel float EXR, exact fp64 NPZ, 8-bit PNG."""

from __future__ import annotations

import json
import tempfile
import zipfile
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import InputError
from ..writing import atomically, require_file
from .film import PLANES
from .render import Picture

SUFFIXES = (".png", ".exr", ".npz")
ROWS = 256  # converted at a time
# LAYER.CHANNEL, and R G B Z by themselves, as OpenEXR's own list of names has it: compositors and viewers show layers of
# X Y Z as vectors and of Y as numbers. "depth" is a distance to all of them, ours the generation of a ray
EXR_CHANNELS = {"color": ("R", "G", "B"), "t": ("Z",), "position": ("P.X", "P.Y", "P.Z"), "normal": ("N.X", "N.Y", "N.Z"),
                "index": ("id.Y",), "depth": ("generation.Y",), "status": ("status.Y",)}


def metadata(picture: Picture) -> dict[str, Any]:
    """Where a picture comes from: scene hash, versions, parameters. Every file format carries it."""
    return {**picture.metadata, "raytruth": version("raytruth"),
            "tracing": picture.scene.tracing.model_dump(mode="json")}


def require_writable(path: Path) -> None:
    """Raises InputError unless a picture can be written to `path`: a known suffix, an existing folder, no folder itself."""
    if path.suffix.lower() not in SUFFIXES:
        raise InputError(f"{path}: the output must end in one of {', '.join(SUFFIXES)}")
    require_file(path)


def planes_of(path: Path) -> tuple[str, ...]:
    """The planes that a file of this suffix holds, and the status, which is always told."""
    return ("color", "status") if path.suffix.lower() == ".png" else PLANES


def save(picture: Picture, path: str | Path) -> None:
    """Writes `picture` in the format its suffix names; a failed write leaves no file. Raises InputError."""
    path = Path(path)
    require_writable(path)
    writer = {".png": save_png, ".exr": save_exr, ".npz": save_npz}[path.suffix.lower()]
    try:
        with atomically(path) as part:
            writer(picture, part)
    except OSError as error:
        raise InputError(f"{path}: cannot be written ({error.strerror or error})") from None


def to_8_bit(color: np.ndarray) -> np.ndarray:
    """Linear values to 0..255: clamped to [0, 1] and rounded to nearest, no gamma (decision P1). NaN becomes 0."""
    pixels = np.empty(color.shape, np.uint8)
    for start in range(0, len(color), ROWS):  # a picture of 8K has no room for copies of its floats
        rows = np.nan_to_num(color[start:start + ROWS], nan=0.0, posinf=1.0, neginf=0.0)
        pixels[start:start + ROWS] = np.floor(np.clip(rows, 0, 1) * 255 + 0.5).astype(np.uint8)
    return pixels


def save_png(picture: Picture, path: Path) -> None:
    write_8_bit(to_8_bit(picture.color), path, metadata(picture))


def write_8_bit(pixels: np.ndarray, path: str | Path, about: dict[str, Any] | None = None) -> None:
    """Writes (h, w, 1 or 3) uint8 as PNG."""
    _write(np.ascontiguousarray(pixels), path, "uint8", [], about or {})


def save_exr(picture: Picture, path: Path) -> None:
    """All planes as float channels, by the names of EXR_CHANNELS."""
    planes = [getattr(picture, name) for name in EXR_CHANNELS]
    channels = np.concatenate([p.reshape(*picture.t.shape, -1).astype(np.float32) for p in planes], axis=-1)
    _write(channels, path, "float", [channel for names in EXR_CHANNELS.values() for channel in names], metadata(picture))


def save_npz(picture: Picture, path: Path) -> None:
    """All planes in full precision, and the metadata as a JSON text; `load_npz` reads it back."""
    arrays = {"metadata": np.array(json.dumps(metadata(picture))), **{name: getattr(picture, name) for name in PLANES}}
    # what numpy.savez_compressed writes, at zlib's fastest level: three times as fast for a tenth more bytes
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED, compresslevel=1) as archive:
        for name, array in arrays.items():
            with archive.open(f"{name}.npy", "w", force_zip64=True) as file:
                np.lib.format.write_array(file, array, allow_pickle=False)


def load_npz(path: str | Path) -> tuple[dict[str, np.ndarray], dict[str, Any]]:
    """The planes and the metadata of a file written by `save_npz`."""
    with np.load(path, allow_pickle=False) as file:
        return {name: file[name] for name in PLANES}, json.loads(str(file["metadata"]))


def png(color: np.ndarray) -> bytes:
    """The file that `save_png` would write of (h, w, 3) linear colours, without where they come from."""
    with tempfile.TemporaryDirectory(prefix="raytruth-") as folder:
        file = Path(folder) / "picture.png"
        write_8_bit(to_8_bit(color), file)
        return file.read_bytes()


def _write(pixels: np.ndarray, path: str | Path, kind: str, names: list[str], about: dict[str, Any]) -> None:
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
