"""Is it the camera? Hits that lie off their pixels' rays, and pictures that agree once they are turned over."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator

import numpy as np

from reference_tracer.tracer.render import Picture
from reference_tracer.scene.model import Scene
from reference_tracer.tracer.sensitivity import UNIT

from .asked import Asked, Pair
from .derived import pixel_directions

OFF = 1e-5  # of a direction, beyond what single precision leaves in a position
EXPLAINED = 0.1  # of the diverging pixels may be left

TURNED: dict[str, Callable[[np.ndarray], np.ndarray]] = {
    "upside down": lambda plane: plane[::-1],
    "mirrored left to right": lambda plane: plane[:, ::-1],
    "turned by half a turn": lambda plane: plane[::-1, ::-1],
    "with rows and columns exchanged": lambda plane: plane.swapaxes(0, 1),
    "a pixel too low": lambda plane: np.roll(plane, -1, axis=0),
    "a pixel too high": lambda plane: np.roll(plane, 1, axis=0),
    "a pixel too far right": lambda plane: np.roll(plane, -1, axis=1),
    "a pixel too far left": lambda plane: np.roll(plane, 1, axis=1),
}


def off_their_rays(picture: Picture) -> tuple[np.ndarray, np.ndarray]:
    """Pixels whose hit does not lie on the ray of section 2 through their centre, and how far its direction is off."""
    camera = np.array(picture.scene.camera.position)
    way = picture.position - camera
    distance = np.linalg.norm(way, axis=-1)
    with np.errstate(invalid="ignore", divide="ignore"):
        off = np.linalg.norm(way / distance[..., None] - pixel_directions(picture.scene), axis=-1)
        allowed = OFF + 16 * UNIT[32] * (1 + np.abs(camera).max()) / distance
        return off > allowed, np.where(np.isfinite(off), off, 0)


def explanation(asked: Asked, pair: Pair, mask: np.ndarray) -> str:
    """What is wrong with the second renderer's camera if that explains the diverging pixels of `mask`; else ""."""
    limit = EXPLAINED * mask.sum()
    for words, turned in TURNED.items():
        planes = turned(pair.b.color), turned(pair.b.index)
        if planes[1].shape == pair.a.index.shape and _differing(pair, pair.a, *planes) <= limit:
            return f"the second picture is {words}"
    for words, scene in _other_fields_of_view(pair.scene):
        if _differing(pair, asked.renderers[0](scene), pair.b.color, pair.b.index) <= limit:
            return f"the second picture has its {words}"
    return ""


def _differing(pair: Pair, a: Picture, color: np.ndarray, index: np.ndarray) -> int:
    """Pixels away from the border that differ in object or colour."""
    fails = (a.index != index) | ~(np.abs(a.color - color).max(-1) <= pair.bound.color)
    return int(fails[1:-1, 1:-1].sum())


def _other_fields_of_view(scene: Scene) -> Iterator[tuple[str, Scene]]:
    camera = scene.camera
    half = math.tan(math.radians(camera.fov) / 2)
    ratio = max(camera.width, camera.height) / min(camera.width, camera.height)
    for words, fov in (("field of view over the shorter side", 2 * math.degrees(math.atan(half * ratio))),
                       ("field of view taken as the half angle", 2 * camera.fov),
                       ("field of view halved", camera.fov / 2)):
        if ratio > 1 or "side" not in words:
            if fov < 179:
                yield words, scene.model_copy(update={"camera": camera.model_copy(update={"fov": fov})})
