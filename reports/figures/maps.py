"""From planes to pixels: the pictures of a run, the error maps between two, and what their captions say."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from reference_tracer.tracer.image_files import to_8_bit

from . import scale
from .planes import Planes
from .scale import Swatch, css, from_oklch

NOTHING = np.array([0, 0, 0], np.uint8)  # where no object was hit
NEAR, FAR = 0.95, 0.30  # lightness of a depth picture's ends
GOLDEN_ANGLE = 137.508  # degrees; successive hues stay far apart however many there are
BINS_A_DECADE = 4
MOST_RINGS = 100  # of one kind; more than that are seen without help


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
    """(h, w, 3) uint8: the colour of the object hit; undecided pixels have the error scale's colour for them."""
    most = max(count, int(planes.index.max()) + 1)
    colours = np.concatenate([object_colours(most), NOTHING[None]])  # index -1 is the last row
    pixels = colours[np.maximum(planes.index, -1)]
    pixels[planes.undecided] = scale.UNDECIDED
    return pixels


@dataclass(frozen=True)
class Errors:
    """How far two pictures are apart; every plane is (h, w). NaN: not finite in one of them."""

    color: np.ndarray  # largest difference of a linear channel
    depth: np.ndarray  # |t - t_reference| / t_reference
    normal: np.ndarray  # angle between the normals, degrees
    objects: np.ndarray  # 0: equality is all there is to show
    nothing: np.ndarray  # bool: neither picture hits anything
    mismatch: np.ndarray  # bool: another object, or a hit in one picture only
    undecided: np.ndarray  # bool: undecided in one picture at least

    def named(self) -> dict[str, np.ndarray]:
        return {"color": self.color, "depth": self.depth, "normal": self.normal, "objects": self.objects}


def color_error(reference: np.ndarray, test: np.ndarray) -> np.ndarray:
    """(h, w): the largest difference of a linear channel; NaN where either is not finite."""
    with np.errstate(invalid="ignore"):
        error = np.abs(test.astype(float) - reference).max(-1)
    return np.where(np.isfinite(error), error, np.nan)


def errors(reference: Planes, test: Planes) -> Errors:
    """The errors of `test`. Where neither hits anything there is no geometry to differ: their error is 0."""
    both = reference.hit & test.hit
    with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
        depth = np.where(both, np.abs(test.t.astype(float) - reference.t) / np.abs(reference.t), 0)
        chord = np.linalg.norm(test.normal.astype(float) - reference.normal, axis=-1)
        # the chord keeps its digits at small angles, where the arc cosine of a dot product has lost them
        normal = np.where(both, np.degrees(2 * np.arcsin(np.minimum(chord / 2, 1))), 0)
    depth, normal = (np.where(np.isfinite(e), e, np.nan) for e in (depth, normal))
    return Errors(color_error(reference.color, test.color), depth, normal, np.zeros(reference.shape),
                  ~reference.hit & ~test.hit, reference.index != test.index, reference.undecided | test.undecided)


@dataclass(frozen=True)
class Bar:
    """One bin of the histogram; all in percent of the drawing."""

    x: float
    width: float
    height: float


@dataclass(frozen=True)
class Spread:
    """How the errors of one map are spread over the scale. Each pixel is counted once, as what `scale.paint` shows it."""

    pixels: int
    nothing: int  # equal, and neither picture hits anything: a large empty background proves nothing
    equal: int  # equal, and something is hit
    special: tuple[tuple[Swatch, int], ...]  # each colour outside the scale that occurs
    largest: float | None  # over all pixels where it is finite; None if it is nowhere
    largest_shown: float | None  # the same over those that have a colour of the scale, if that is less
    bars: tuple[Bar, ...]


def spread(error: np.ndarray, errors: Errors) -> Spread:
    """How one error plane of `errors` is spread."""
    non_finite = ~np.isfinite(error)
    undecided = errors.undecided & ~non_finite
    mismatch = errors.mismatch & ~undecided & ~non_finite
    measured = ~(non_finite | undecided | mismatch)
    equal = measured & (error == 0)
    special = zip(scale.SPECIAL, (mismatch, undecided, non_finite))
    largest, shown = (float(error[mask].max()) if mask.any() else None for mask in (~non_finite, measured))
    return Spread(error.size, int((equal & errors.nothing).sum()), int((equal & ~errors.nothing).sum()),
                  tuple((swatch, int(mask.sum())) for swatch, mask in special if mask.any()),
                  largest, None if shown == largest else shown, _bars(error[measured]))


def _bars(measured: np.ndarray) -> tuple[Bar, ...]:
    """Heights grow with the logarithm of the count, so that one pixel among a million is still seen."""
    bins = scale.DECADES * BINS_A_DECADE
    position = np.log10(np.clip(measured[measured > 0], scale.LOW, scale.HIGH) / scale.LOW) * BINS_A_DECADE
    counts = np.bincount(np.minimum(position.astype(int), bins - 1), minlength=bins)
    top = np.log1p(max(measured.size, 1))
    return tuple(Bar(100 * i / bins, 100 / bins, float(100 * np.log1p(n) / top)) for i, n in enumerate(counts) if n)


@dataclass(frozen=True)
class Ring:
    """Around the point (x, y), in pixels from the picture's upper left corner: at half its size a pixel is not seen."""

    x: float
    y: float
    colour: str


def around_worst(worst: list[dict[str, float | int]], shape: tuple[int, int]) -> tuple[Ring, ...]:
    """Around the pixels that a comparison lists as its worst, as far as they lie in a picture of `shape`."""
    places = [(pixel.get("row", -1), pixel.get("col", -1)) for pixel in worst]
    height, width = shape
    return tuple(Ring(col + 0.5, row + 0.5, "#ffffff") for row, col in places if 0 <= row < height and 0 <= col < width)


def around_special(errors: Errors) -> tuple[Ring, ...]:
    """Around pixels that see another object, and around undecided ones, each kind if it is rare."""
    rings = []
    for mask, colour in ((errors.mismatch & ~errors.undecided, scale.MISMATCH), (errors.undecided, scale.UNDECIDED)):
        places = np.argwhere(mask)
        if len(places) <= MOST_RINGS:
            rings += [Ring(float(col) + 0.5, float(row) + 0.5, css(colour)) for row, col in places]
    return tuple(rings)
