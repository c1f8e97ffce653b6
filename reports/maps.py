"""From planes to pixels: the pictures of one side, and the error maps between two."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from reference_tracer.tracer.image_files import to_8_bit

from . import scale
from .colours import css, from_oklch
from .planes import Planes

NOTHING = np.array([0, 0, 0], np.uint8)  # where no object was hit
NEAR, FAR = 0.95, 0.30  # lightness of a depth picture's ends
GOLDEN_ANGLE = 137.508  # degrees; successive hues stay far apart however many there are


def depth_range(planes: Planes) -> tuple[float, float]:
    """The nearest and the farthest hit; (1, 1) if there is none."""
    t = planes.t[planes.hit & np.isfinite(planes.t) & (planes.t > 0)]
    return (float(t.min()), float(t.max())) if t.size else (1.0, 1.0)


def depth_picture(planes: Planes, span: tuple[float, float]) -> np.ndarray:
    """(h, w, 3) uint8: near is light, far is dark, evenly in log t over `span`; black where nothing was hit."""
    near, far = np.log(span)
    valid = planes.hit & np.isfinite(planes.t) & (planes.t > 0)
    position = (np.log(np.where(valid, planes.t, span[0])) - near) / max(far - near, 1e-12)
    greys = from_oklch(np.linspace(NEAR, FAR, 256), 0.0, 0.0)
    pixels = greys[np.round(255 * np.clip(position, 0, 1)).astype(np.intp)]
    pixels[~planes.hit] = NOTHING
    pixels[planes.hit & ~valid] = scale.NON_FINITE
    return pixels


def normal_picture(planes: Planes) -> np.ndarray:
    """(h, w, 3) uint8: red, green and blue are x, y and z from -1 to 1; black where nothing was hit."""
    pixels = to_8_bit((planes.normal + 1) / 2)
    pixels[~planes.hit] = NOTHING
    pixels[planes.hit & ~np.isfinite(planes.normal).all(-1)] = scale.NON_FINITE
    return pixels


def object_colours(count: int) -> np.ndarray:
    """(count, 3) uint8: a colour for every object of a scene."""
    number = np.arange(count)
    return from_oklch(np.where(number % 2, 0.62, 0.76), 0.115, 250 + GOLDEN_ANGLE * number)


def object_picture(planes: Planes, count: int) -> np.ndarray:
    """(h, w, 3) uint8: the colour of the object hit; undecided pixels have the error scale's mark."""
    most = max(count, int(planes.index.max()) + 1)
    colours = np.concatenate([object_colours(most), NOTHING[None]])  # index -1 is the last row
    pixels = colours[np.maximum(planes.index, -1)]
    pixels[planes.undecided] = scale.UNDECIDED
    return pixels


def object_swatches(count: int) -> list[str]:
    return [css(colour) for colour in object_colours(count)]


@dataclass(frozen=True)
class Errors:
    """How far two pictures are apart; every plane is (h, w). NaN: not finite on one of the sides."""

    color: np.ndarray  # largest difference of a linear channel
    depth: np.ndarray  # |t - t_reference| / t_reference
    normal: np.ndarray  # angle between the normals, radians
    objects: np.ndarray  # 0: equality is all there is to show
    nothing: np.ndarray  # bool: neither side hits anything
    mismatch: np.ndarray  # bool: another object, or a hit on one side only
    undecided: np.ndarray  # bool: undecided on one side at least

    def named(self) -> dict[str, np.ndarray]:
        return {"color": self.color, "depth": self.depth, "normal": self.normal, "objects": self.objects}


def errors(reference: Planes, test: Planes) -> Errors:
    """The errors of `test`. Where both sides hit nothing there is no geometry to differ: their error is 0."""
    both = reference.hit & test.hit
    with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
        color = np.abs(test.color.astype(float) - reference.color).max(-1)
        depth = np.where(both, np.abs(test.t.astype(float) - reference.t) / np.abs(reference.t), 0)
        chord = np.linalg.norm(test.normal.astype(float) - reference.normal, axis=-1)
        # the chord keeps its digits at small angles, where the arc cosine of a dot product has lost them
        normal = np.where(both, 2 * np.arcsin(np.minimum(chord / 2, 1)), 0)
    return Errors(*(np.where(np.isfinite(e), e, np.nan) for e in (color, depth, normal)), np.zeros(reference.shape),
                  ~reference.hit & ~test.hit, reference.index != test.index, reference.undecided | test.undecided)
