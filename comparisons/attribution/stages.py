"""The stages of section 4 in the order in which a ray meets them, each compared on scenes that isolate it.

A stage yields findings: pixels of one derived scene that are apart by more than their bound. What an earlier stage
explains (the same pixel, apart for another reason) does not count; `measure` takes it out.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
from skimage.morphology import erosion

from raytruth.reference_tracer.scene.model import Scene
from raytruth.reference_tracer.tracer.render import Picture
from raytruth.reference_tracer.tracer.sensitivity import UNIT

from ..verdicts.metrics import pixel_error
from . import derived
from .bounds import AROUND, Accuracy, Bounds, accuracy_of, bounds
from .document import STAGES, Stage

FEWEST = 4  # pixels that may always stray
CLUSTERED = 0.1  # of them may be whole 3 x 3 neighbourhoods
OFF = 1e-5  # of a direction, beyond what single precision leaves in a position
EXPLAINED = 0.1  # of the diverging pixels may be left
MOST_WITHIN = 4  # objects looked at from within
MOSTLY = 0.5  # of the pixels: dark there is no shadow


@dataclass(frozen=True)
class Pair:
    """Both pictures of a scene, and their bounds. All methods give a plane (h, w)."""

    scene: Scene
    a: Picture
    b: Picture
    bound: Bounds
    accuracy: Accuracy

    @property
    def same_hit(self) -> np.ndarray:
        return (self.a.index == self.b.index) & (self.a.index >= 0)

    def color_error(self) -> np.ndarray:
        """Infinite where a colour is not finite."""
        error = pixel_error(self.a.color, self.b.color)
        return np.where(np.isnan(error), np.inf, error)

    def color_fails(self) -> np.ndarray:
        return self.bound.decided & (self.color_error() > self.bound.color)

    def one_dark(self) -> np.ndarray:
        """Where a channel differs and is unlit in one picture."""
        apart, dark = self._channels()
        return self.bound.decided & (apart & dark).any(-1)

    def both_lit(self) -> np.ndarray:
        """Where a channel differs and is lit in both pictures, or is no number."""
        apart, dark = self._channels()
        return self.bound.decided & (apart & ~dark).any(-1)

    def _channels(self) -> tuple[np.ndarray, np.ndarray]:
        """(h, w, 3) each: what differs or is no number, and what is unlit in a picture."""
        a, b, bound = self.a.color, self.b.color, self.bound.color[..., None]
        return ~(np.abs(a - b) <= bound), np.minimum(a, b) <= bound

    def is_dark(self) -> bool:
        """Whether one picture is unlit nearly everywhere on a scene that has no shadow."""
        return self.one_dark().sum() > MOSTLY * max(self.same_hit.sum(), 1)

    def lit_wrongly(self) -> np.ndarray:
        """Where the light differs on a scene that has no shadow: what is dark only here and there is in one."""
        return self.color_fails() if self.is_dark() else self.both_lit()

    def significant(self, mask: np.ndarray) -> bool:
        """Whether more pixels diverge than may stray."""
        allowed = max(FEWEST, self.accuracy.stray * mask.size)
        return bool(mask.sum() > allowed or erosion(mask, AROUND).sum() > CLUSTERED * allowed)


class Pictures:
    """Pictures by both renderers, each made once."""

    def __init__(self, a: Callable[[Scene], Picture], b: Callable[[Scene], Picture]):
        self.renderers = a, b
        self._pairs: dict[str, Pair] = {}

    def pair(self, scene: Scene) -> Pair:
        if scene.hash not in self._pairs:
            a, b = (render(scene) for render in self.renderers)
            accuracy = accuracy_of([a, b])
            self._pairs[scene.hash] = Pair(scene, a, b, bounds(scene, accuracy), accuracy)
        return self._pairs[scene.hash]


@dataclass(frozen=True)
class Finding:
    """Pixels (h, w) of one derived scene at which a stage diverges."""

    question: str
    pair: Pair
    mask: np.ndarray
    error: np.ndarray
    unit: str
    detail: str = ""


GEOMETRY = "white opaque objects lit from the camera"


def camera(pictures: Pictures, scene: Scene) -> Iterator[Finding]:
    pair = pictures.pair(derived.geometry(scene))
    for which, picture in (("the first", pair.a), ("the second", pair.b)):
        mask, error = _off_their_rays(picture)
        yield Finding(f"{GEOMETRY}: do {which} renderer's hits lie on their pixels' rays?", pair, mask, error,
                      "direction", f"{which} renderer's hits lie off the rays of section 2")


def hit(pictures: Pictures, scene: Scene) -> Iterator[Finding]:
    pair = pictures.pair(derived.geometry(scene))
    a, b = pair.a.index, pair.b.index
    mask = pair.bound.decided & (a != b) & ~(pair.bound.allows(a) & pair.bound.allows(b))
    yield Finding(f"{GEOMETRY}: the object that is hit", pair, mask, (a != b).astype(float), "another object")


def root(pictures: Pictures, scene: Scene) -> Iterator[Finding]:
    pair = pictures.pair(derived.geometry(scene))
    both = pair.same_hit & np.isfinite(pair.a.t) & np.isfinite(pair.b.t)
    apart = np.abs(np.where(both, pair.a.t, 0) - np.where(both, pair.b.t, 0))
    yield Finding(f"{GEOMETRY}: the distance of the hit", pair, pair.bound.decided & (apart > pair.bound.t),
                  apart / np.maximum(np.where(both, pair.a.t, 1), 1e-30), "relative distance")


def normal(pictures: Pictures, scene: Scene) -> Iterator[Finding]:
    pair = pictures.pair(derived.geometry(scene))
    yield _normals(pair, f"{GEOMETRY}: the normal")
    entered = [k for k, o in enumerate(scene.objects) if o.material.transparency > 0]
    for k in entered[:MOST_WITHIN]:
        inner = derived.within(scene, k, {"index": pair.a.index, "t": pair.a.t})
        if inner is not None:
            yield _normals(pictures.pair(inner), f"object {k} alone, seen from within: the normal")


def _normals(pair: Pair, question: str) -> Finding:
    apart = np.linalg.norm(pair.a.normal - pair.b.normal, axis=-1)
    known = pair.same_hit & np.isfinite(apart)
    if known.sum() >= MOSTLY * pair.same_hit.sum():
        apart = np.where(known, apart, 0)
        return Finding(question, pair, pair.bound.decided & (apart > pair.bound.normal), apart, "length of the difference")
    # a renderer that does not tell normals shows their cosine
    return _colors(f"{question}, told by the colour", pair, pair.lit_wrongly() & pair.same_hit)


def _colors(question: str, pair: Pair, mask: np.ndarray) -> Finding:
    return Finding(question, pair, mask, pair.color_error(), "colour")


def shading(pictures: Pictures, scene: Scene) -> Iterator[Finding]:
    pair = pictures.pair(derived.geometry(scene))
    yield _colors(f"{GEOMETRY}: the colour", pair, pair.lit_wrongly())
    apart = np.zeros_like(pair.bound.decided)
    for one in derived.lights_apart(scene):
        pair = pictures.pair(one)
        apart |= pair.color_fails()
        yield _colors("white opaque objects, each light in a channel of its own: the light that arrives", pair,
                      _missing_lights(pair) | pair.both_lit() & ~pair.one_dark())
    pair = pictures.pair(derived.local(scene))
    yield _colors("opaque objects in their colours under all lights", pair, pair.color_fails() & ~apart)


def _missing_lights(pair: Pair) -> np.ndarray:
    """Pixels that differ in a channel that one side alone leaves dark everywhere: no shadow is as large."""
    dark = [(p.color <= pair.bound.color[..., None]).all(axis=(0, 1)) for p in (pair.a, pair.b)]
    return ((np.abs(pair.a.color - pair.b.color) > pair.bound.color[..., None]) & (dark[0] != dark[1])).any(-1)


def shadow(pictures: Pictures, scene: Scene) -> Iterator[Finding]:
    pair = pictures.pair(derived.geometry(scene))
    yield _colors(f"{GEOMETRY}: is any point in shadow?", pair, pair.one_dark())
    for one in derived.lights_apart(scene):
        pair = pictures.pair(one)
        yield _colors("white opaque objects, each light in a channel of its own: what is in shadow", pair,
                      pair.one_dark())
    if any(o.material.transparency > 0 for o in scene.objects):
        pair = pictures.pair(derived.shadows(scene))
        weighed_wrongly = pictures.pair(derived.weights(derived.shadows(scene))).color_fails()
        yield _colors("light through transparent objects, nothing seen through them", pair,
                      pair.color_fails() & ~weighed_wrongly)


def reflection(pictures: Pictures, scene: Scene) -> Iterator[Finding]:
    if any(o.material.reflection > 0 for o in scene.objects) and scene.tracing.max_depth > 0:
        pair = pictures.pair(derived.mirrors(scene))
        yield _colors("perfect black mirrors in place of what reflects, all else opaque", pair, pair.color_fails())


def refraction(pictures: Pictures, scene: Scene) -> Iterator[Finding]:
    if any(o.material.transparency > 0 for o in scene.objects) and scene.tracing.max_depth > 0:
        pair = pictures.pair(derived.glass(scene))
        yield _colors("perfectly clear objects in place of transparent ones, all else opaque", pair, pair.color_fails())


def mixing(pictures: Pictures, scene: Scene) -> Iterator[Finding]:
    for question, one in (("the scene's materials lit from the camera, without secondary rays", derived.weights(scene)),
                          ("the whole scene, one sample a pixel", derived.whole(scene))):
        pair = pictures.pair(one)
        yield _colors(question, pair, pair.color_fails())


def sampling(pictures: Pictures, scene: Scene) -> Iterator[Finding]:
    if scene.tracing.samples > 1:
        pair = pictures.pair(scene)
        yield _colors(f"the whole scene, {scene.tracing.samples} x {scene.tracing.samples} samples a pixel", pair,
                      pair.color_fails())


COMPARE: dict[Stage, Callable[[Pictures, Scene], Iterator[Finding]]] = dict(zip(STAGES, (
    camera, hit, root, normal, shading, shadow, reflection, refraction, mixing, sampling)))


# --- is it the camera? ------------------------------------------------------------------------------------------------
TURNED: dict[str, Callable[[np.ndarray], np.ndarray]] = {
    "upside down": lambda plane: plane[::-1],
    "mirrored left to right": lambda plane: plane[:, ::-1],
    "turned by half a turn": lambda plane: plane[::-1, ::-1],
    "with rows and columns exchanged": lambda plane: plane.swapaxes(0, 1),
    "a pixel too low": lambda plane: np.roll(plane, -1, axis=0),
    "a pixel too high": lambda plane: np.roll(plane, 1, axis=0),
    "a pixel too far right": lambda plane: np.roll(plane, -1, axis=1),
    "a pixel too far left": lambda plane: np.roll(plane, 1, axis=1)}


def _off_their_rays(picture: Picture) -> tuple[np.ndarray, np.ndarray]:
    """Pixels whose hit does not lie on the ray of section 2 through their centre, and how far its direction is off."""
    camera = np.array(picture.scene.camera.position)
    way = picture.position - camera
    distance = np.linalg.norm(way, axis=-1)
    with np.errstate(invalid="ignore", divide="ignore"):
        off = np.linalg.norm(way / distance[..., None] - derived.pixel_directions(picture.scene), axis=-1)
        allowed = OFF + 16 * UNIT[32] * (1 + np.abs(camera).max()) / distance
        return off > allowed, np.where(np.isfinite(off), off, 0)


def camera_fault(pictures: Pictures, pair: Pair, mask: np.ndarray) -> str:
    """What is wrong with the second renderer's camera if that explains the diverging pixels of `mask`; else ""."""
    limit = EXPLAINED * mask.sum()
    for how, turned in TURNED.items():
        planes = turned(pair.b.color), turned(pair.b.index)
        if planes[1].shape == pair.a.index.shape and _differing(pair, pair.a, *planes) <= limit:
            return f"the second picture is {how}"
    for how, scene in _other_fields_of_view(pair.scene):
        if _differing(pair, pictures.renderers[0](scene), pair.b.color, pair.b.index) <= limit:
            return f"the second picture has its {how}"
    return ""


def _differing(pair: Pair, a: Picture, color: np.ndarray, index: np.ndarray) -> int:
    """Pixels away from the border that differ in object or colour."""
    fails = (a.index != index) | ~(np.abs(a.color - color).max(-1) <= pair.bound.color)
    return int(fails[1:-1, 1:-1].sum())


def _other_fields_of_view(scene: Scene) -> Iterator[tuple[str, Scene]]:
    camera = scene.camera
    ratio = max(camera.width, camera.height) / min(camera.width, camera.height)
    shorter = 2 * math.degrees(math.atan(math.tan(math.radians(camera.fov) / 2) * ratio))
    for how, fov in (("field of view over the shorter side", shorter if ratio > 1 else math.inf),
                     ("field of view taken as the half angle", 2 * camera.fov), ("field of view halved", camera.fov / 2)):
        if fov < 179:
            yield how, scene.model_copy(update={"camera": camera.model_copy(update={"fov": fov})})
