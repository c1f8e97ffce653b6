"""Small scenes for the families of the whole model, and the families themselves."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import drjit as dr
import numpy as np

from reference_tracer.backend import backend
from reference_tracer.rays import Ray, Sides
from reference_tracer.scene.load import parse_scene
from reference_tracer.scene.model import Scene
from reference_tracer.world import World

from .family import About, Outcome, counted
from .law import Law
from .methods import Method, Setting
from .outcome import CODE, WRONG
from .rays import Draw


def plane(normal, center, **material) -> dict:
    """A half-space behind a plane, as a scene document writes it."""
    a, b, c = map(float, normal)
    return {"surface": {"type": "plane", "center": [float(v) for v in center], "a": a, "b": b, "c": c},
            "material": material}


def scene(*objects: dict, camera, lights=(), **tracing) -> Scene:
    """A scene through the parser, as a user's file comes. `camera` is where the rays start: it fixes their sides.

    A scene that names no light gets a black one.
    """
    shining = [{"position": list(map(float, position))} for position in lights]
    document = {"camera": {"position": [float(v) for v in camera]}, "objects": list(objects),
                "lights": shining or [{"position": [0, 0, 0], "brightness": [0, 0, 0]}],
                "tracing": {"step_size": 0.05, **tracing}}
    return parse_scene(json.dumps(document).encode(), "stability case")


def world_of(scene: Scene, method: Method, precision: int) -> World | None:
    """`scene` with `method` for every surface; None where the method does not apply to one of them."""
    world = World(scene, "exact", backend(precision))
    for family in world.families:
        degree = scene.objects[family.indices[0]].surface.degree
        family.method = method.build(Setting(degree, world.arrays, scene.tracing.step_size))
        if family.method is None:
            return None
    return world


def camera_rays(world: World, o: np.ndarray, d: np.ndarray) -> Ray:
    """Rays from points that lie on the same side of everything as the camera."""
    arrays = world.arrays
    vector = lambda v: arrays.Vector(*(arrays.Float(np.ascontiguousarray(v[:, k])) for k in range(3)))
    sides = Sides([word + dr.zeros(arrays.Bits, len(o)) for word in world.camera_sides().words])
    ray = Ray(vector(o), vector(d), sides)
    dr.eval(ray)
    return ray


@dataclass
class Observed:
    """What became of n rays: the kind of each (index into outcome.NAMES) and how far it is off where it is correct."""

    kinds: np.ndarray
    error: np.ndarray


@dataclass(frozen=True)
class ModelFamily:
    """Rays through a small scene. `case(p, draw)` gives the rays and the truth, `observe(case, method, precision)`
    what a method makes of them (None where it does not apply)."""

    about: About
    case: Callable[[float, Draw], Any]
    observe: Callable[[Any, Method, int], Observed | None]
    laws: tuple[Law, ...] = ()
    variants: tuple[Method, ...] = ()

    def cases(self, precision: int, count: int) -> list:
        return [self.case(p, self.about.draw(p, precision, count)) for p in self.about.values_in(precision)]

    def run(self, cases: list, method: Method, precision: int) -> list[Outcome] | None:
        observed = [self.observe(case, method, precision) for case in cases]
        return None if observed[0] is None else [_outcome(seen, case) for seen, case in zip(observed, cases)]


def _outcome(seen: Observed, case) -> Outcome:
    right = seen.error[(seen.kinds == CODE["correct"]) & np.isfinite(seen.error)]
    wrong = np.flatnonzero(np.isin(seen.kinds, [CODE[name] for name in WRONG]))
    example = None
    if len(wrong):
        i = int(wrong[0])
        example = {"kind": list(CODE)[seen.kinds[i]], "o": case.o[i].tolist(), "d": case.d[i].tolist(),
                   "error": float(seen.error[i])}
    return Outcome(counted(seen.kinds), float(right.max()) if len(right) else None, None, example)


def judged(error: np.ndarray, accuracy: float, *, met, undecided) -> Observed:
    """Kinds from the distance of values to the exact ones; `met` tells which rays met what they had to meet."""
    kinds = np.full(len(error), CODE["correct"])
    for name, where in (("wrong value", error > accuracy), ("non-finite", ~np.isfinite(error)), ("missed", ~met),
                        ("undecided", undecided)):
        kinds[where] = CODE[name]
    return Observed(kinds, error)
