"""The planes a renderer leaves. Another process wrote them: what they are is checked before anybody computes with them."""

from __future__ import annotations

import zipfile
from pathlib import Path

import numpy as np

from raytruth.reference_tracer.scene.model import Scene
from raytruth.reference_tracer.tracer.image_files import load_npz

KINDS = {"color": ("f", (3,)), "t": ("f", ()), "position": ("f", (3,)), "normal": ("f", (3,)), "index": ("iu", ()),
         "depth": ("iu", ()), "status": ("iu", ())}  # kinds of numbers, and their shape at a pixel
LARGEST_EXTRA = 1 << 20  # bytes of a plane's header, or of the metadata


def read_planes(path: Path, camera: tuple[float, float, float]) -> dict[str, np.ndarray]:
    """The planes of a picture, and the `camera`'s position under "camera"."""
    planes, _ = load_npz(path)
    return {**planes, "camera": np.array(camera)}


def problem(path: Path, scene: Scene) -> str | None:
    """What is wrong with the planes in `path` as a picture of `scene`, in one line; None if nothing is."""
    height, width = scene.camera.height, scene.camera.width
    if not path.exists():
        return "left no planes"
    try:
        with zipfile.ZipFile(path) as archive:  # sizes first: a few bytes can unpack to any number
            if max(member.file_size for member in archive.infolist()) > 24 * height * width + LARGEST_EXTRA:
                return f"left planes too large for {width} x {height} pixels"
        planes, _ = load_npz(path)
    except Exception as error:  # anything may be in there
        return f"left planes that cannot be read ({type(error).__name__})"
    if planes["color"].shape != (height, width, 3):
        shape = " x ".join(map(str, planes["color"].shape[1::-1])) or "0"
        return f"left a picture of {shape} instead of {width} x {height} pixels"
    for name, (kinds, shape) in KINDS.items():
        if planes[name].shape != (height, width, *shape) or planes[name].dtype.kind not in kinds:
            return f"left a plane {name!r} that is none: shape {planes[name].shape}, type {planes[name].dtype}"
    if not np.isfinite(planes["color"]).any():
        return "left a picture without one finite colour"
    if not -1 <= planes["index"].min() <= planes["index"].max() < len(scene.objects):
        return f"left objects {planes['index'].min()} to {planes['index'].max()} of a scene with {len(scene.objects)}"
    return None
