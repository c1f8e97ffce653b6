"""The stages of section 4 in the order in which a ray meets them, each asked by scenes that isolate it.

A stage yields findings: pixels of one derived scene that are apart by more than their bound. What an earlier stage
explains (the same pixel, apart for another reason) does not count; `attribute` takes it out.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from reference_tracer.scene.model import Scene

from . import derived
from .asked import Asked, Pair
from .camera import off_their_rays
from .records import Stage

MOST_WITHIN = 4  # objects looked at from within
MOSTLY = 0.5  # of the pixels: dark there is no shadow


@dataclass(frozen=True)
class Finding:
    """Pixels (h, w) of one derived scene at which a stage diverges."""

    question: str
    pair: Pair
    mask: np.ndarray
    error: np.ndarray
    unit: str
    detail: str = ""


Stages = Callable[[Asked, Scene], Iterator[Finding]]
GEOMETRY = "white opaque objects lit from the camera"


def camera(asked: Asked, scene: Scene) -> Iterator[Finding]:
    pair = asked.pair(derived.geometry(scene))
    for side, picture in (("the first", pair.a), ("the second", pair.b)):
        mask, error = off_their_rays(picture)
        yield Finding(f"{GEOMETRY}: do {side} renderer's hits lie on their pixels' rays?", pair, mask, error,
                      "direction", f"{side} renderer's hits lie off the rays of section 2")


def hit(asked: Asked, scene: Scene) -> Iterator[Finding]:
    pair = asked.pair(derived.geometry(scene))
    a, b = pair.a.index, pair.b.index
    mask = pair.bound.decided & (a != b) & ~(pair.bound.allows(a) & pair.bound.allows(b))
    yield Finding(f"{GEOMETRY}: the object that is hit", pair, mask, (a != b).astype(float), "another object")


def root(asked: Asked, scene: Scene) -> Iterator[Finding]:
    pair = asked.pair(derived.geometry(scene))
    both = pair.same_hit & np.isfinite(pair.a.t) & np.isfinite(pair.b.t)
    apart = np.abs(np.where(both, pair.a.t, 0) - np.where(both, pair.b.t, 0))
    yield Finding(f"{GEOMETRY}: the distance of the hit", pair, pair.bound.decided & (apart > pair.bound.t),
                  apart / np.maximum(np.where(both, pair.a.t, 1), 1e-30), "relative distance")


def normal(asked: Asked, scene: Scene) -> Iterator[Finding]:
    pair = asked.pair(derived.geometry(scene))
    yield _normals(pair, f"{GEOMETRY}: the normal")
    entered = [k for k, o in enumerate(scene.objects) if o.material.transparency > 0]
    for k in entered[:MOST_WITHIN]:
        inner = derived.within(scene, k, {"index": pair.a.index, "t": pair.a.t})
        if inner is not None:
            yield _normals(asked.pair(inner), f"object {k} alone, seen from within: the normal")


def _normals(pair: Pair, question: str) -> Finding:
    apart = np.linalg.norm(pair.a.normal - pair.b.normal, axis=-1)
    told = pair.same_hit & np.isfinite(apart)
    if told.sum() >= MOSTLY * pair.same_hit.sum():
        apart = np.where(told, apart, 0)
        return Finding(question, pair, pair.bound.decided & (apart > pair.bound.normal), apart, "length of the difference")
    # a renderer that does not tell normals shows their cosine; what is dark here and there is in shadow
    mask = pair.color_fails() if _is_dark(pair) else pair.both_lit()
    return Finding(f"{question}, told by the colour", pair, mask & pair.same_hit, pair.color_error(), "colour")


def _is_dark(pair: Pair) -> bool:
    """Whether one side is unlit nearly everywhere on a scene that has no shadow."""
    return pair.one_dark().sum() > MOSTLY * max(pair.same_hit.sum(), 1)


def shading(asked: Asked, scene: Scene) -> Iterator[Finding]:
    pair = asked.pair(derived.geometry(scene))
    yield Finding(f"{GEOMETRY}: the colour", pair, pair.color_fails() if _is_dark(pair) else pair.both_lit(),
                  pair.color_error(), "colour")
    apart = np.zeros_like(pair.bound.decided)
    for one in derived.lights_apart(scene):
        pair = asked.pair(one)
        apart |= pair.color_fails()
        yield Finding("white opaque objects, each light in a channel of its own: the light that arrives", pair,
                      _missing_lights(pair) | pair.both_lit() & ~pair.one_dark(), pair.color_error(), "colour")
    pair = asked.pair(derived.local(scene))
    yield Finding("opaque objects in their colours under all lights", pair, pair.color_fails() & ~apart,
                  pair.color_error(), "colour")


def _missing_lights(pair: Pair) -> np.ndarray:
    """Pixels that differ in a channel that one side alone leaves dark everywhere: no shadow is as large."""
    dark = [(p.color <= pair.bound.color[..., None]).all(axis=(0, 1)) for p in (pair.a, pair.b)]
    return ((np.abs(pair.a.color - pair.b.color) > pair.bound.color[..., None]) & (dark[0] != dark[1])).any(-1)


def shadow(asked: Asked, scene: Scene) -> Iterator[Finding]:
    pair = asked.pair(derived.geometry(scene))
    yield Finding(f"{GEOMETRY}: is any point in shadow?", pair, pair.one_dark(), pair.color_error(), "colour")
    for one in derived.lights_apart(scene):
        pair = asked.pair(one)
        yield Finding("white opaque objects, each light in a channel of its own: what is in shadow", pair,
                      pair.one_dark(), pair.color_error(), "colour")
    if any(o.material.transparency > 0 for o in scene.objects):
        pair = asked.pair(derived.shadows(scene))
        weighed_wrongly = asked.pair(derived.weights(derived.shadows(scene))).color_fails()
        yield Finding("light through transparent objects, nothing seen through them", pair,
                      pair.color_fails() & ~weighed_wrongly, pair.color_error(), "colour")


def reflection(asked: Asked, scene: Scene) -> Iterator[Finding]:
    if any(o.material.reflection > 0 for o in scene.objects) and scene.tracing.max_depth > 0:
        pair = asked.pair(derived.mirrors(scene))
        yield Finding("perfect black mirrors in place of what reflects, all else opaque", pair, pair.color_fails(),
                      pair.color_error(), "colour")


def refraction(asked: Asked, scene: Scene) -> Iterator[Finding]:
    if any(o.material.transparency > 0 for o in scene.objects) and scene.tracing.max_depth > 0:
        pair = asked.pair(derived.glass(scene))
        yield Finding("perfectly clear objects in place of transparent ones, all else opaque", pair, pair.color_fails(),
                      pair.color_error(), "colour")


def mixing(asked: Asked, scene: Scene) -> Iterator[Finding]:
    for question, one in (("the scene's materials lit from the camera, without secondary rays", derived.weights(scene)),
                          ("the whole scene, one sample a pixel", derived.whole(scene))):
        pair = asked.pair(one)
        yield Finding(question, pair, pair.color_fails(), pair.color_error(), "colour")


def sampling(asked: Asked, scene: Scene) -> Iterator[Finding]:
    if scene.tracing.samples > 1:
        pair = asked.pair(scene)
        yield Finding(f"the whole scene, {scene.tracing.samples} x {scene.tracing.samples} samples a pixel", pair,
                      pair.color_fails(), pair.color_error(), "colour")


ASK: dict[Stage, Stages] = {"camera": camera, "hit": hit, "root": root, "normal": normal, "shading": shading,
                            "shadow": shadow, "reflection": reflection, "refraction": refraction, "mixing": mixing,
                            "sampling": sampling}
