"""Small scenes for the families of the whole model, and the families themselves."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import dataclass
from itertools import groupby

import drjit as dr
import numpy as np

from reference_tracer.backend import backend
from reference_tracer.tracer.rays import Ray, Sides
from reference_tracer.scene.load import parse_scene
from reference_tracer.scene.model import Scene
from reference_tracer.tracer.world import World

from .family import About, Outcome, counted
from .law import Law
from .methods import Method, Setting
from .outcome import CODE, NAMES, WRONG
from .rays import Draw


def plane(normal, center, **material) -> dict:
    """A half-space behind a plane, as a scene document writes it."""
    a, b, c = map(float, normal)
    return {"surface": {"type": "plane", "center": [float(v) for v in center], "a": a, "b": b, "c": c},
            "material": material}


def scene(*objects: dict, camera, lights=(), **tracing) -> Scene:
    """A scene through the parser, as a user's file comes. `camera` is where the rays start: it fixes their sides."""
    document = {"camera": {"position": [float(v) for v in camera]}, "objects": list(objects),
                "lights": [{"position": list(map(float, position))} for position in lights],
                "tracing": {"step_size": 0.05, **tracing}}
    return parse_scene(json.dumps(document).encode(), "stability case")


def world_of(scene: Scene, method: Method, precision: int) -> World | None:
    """`scene` with `method` for every surface; None where the method does not apply to one of them."""
    world = World(scene, "exact", backend(precision))
    for family in world.families:
        degree = scene.objects[family.indices[0]].surface.degree
        family.method = method.build(Setting(degree, world.arrays, scene.tracing.step_size, family.bounded))
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
class Case:
    """Rays from the camera's side of everything in a scene, and the truth about each, by name; arrays of length n."""

    scene: Scene
    o: np.ndarray  # (n, 3)
    d: np.ndarray  # (n, 3)
    truth: dict[str, np.ndarray]

    @staticmethod
    def joined(cases: list[Case]) -> Case:
        """All the rays of cases of one scene."""
        together = lambda pick: np.concatenate([pick(case) for case in cases])
        return Case(cases[0].scene, together(lambda c: c.o), together(lambda c: c.d),
                    {name: together(lambda c, name=name: c.truth[name]) for name in cases[0].truth})


@dataclass
class Observed:
    """What became of n rays: the kind of each (index into outcome.NAMES) and how far it is off the truth."""

    kinds: np.ndarray
    error: np.ndarray


@dataclass(frozen=True)
class ModelFamily:
    """Rays through a small scene. `case(p, draw)` gives the rays and the truth, `observe(case, method, precision)`
    what a method makes of them (None where it does not apply). Values of p that share a scene run in one batch."""

    about: About
    case: Callable[[float, Draw], Case]
    observe: Callable[[Case, Method, int], Observed | None]
    laws: tuple[Law, ...] = ()
    variants: tuple[Method, ...] = ()

    def cases(self, precision: int, count: int) -> list[Case]:
        return [self.case(p, self.about.draw(p, precision, count)) for p in self.about.values_in(precision)]

    def run(self, cases: list[Case], method: Method, precision: int) -> list[Outcome] | None:
        outcomes = []
        for _, batch in groupby(cases, key=lambda case: case.scene):
            batch = list(batch)
            seen = self.observe(Case.joined(batch), method, precision)
            if seen is None:
                return None
            ends = np.cumsum([len(case.o) for case in batch])
            outcomes += [_outcome(case, seen.kinds[end - len(case.o):end], seen.error[end - len(case.o):end])
                         for case, end in zip(batch, ends)]
        return outcomes


def _outcome(case: Case, kinds: np.ndarray, error: np.ndarray) -> Outcome:
    right = error[(kinds == CODE["correct"]) & np.isfinite(error)]
    wrong = np.flatnonzero(np.isin(kinds, [CODE[name] for name in WRONG]))
    example = None
    if len(wrong):
        i = int(wrong[0])
        example = {"kind": NAMES[kinds[i]], "o": case.o[i].tolist(), "d": case.d[i].tolist(), "error": float(error[i])}
    return Outcome(counted(kinds), float(right.max()) if len(right) else None, None, example)


def judged(error: np.ndarray, accuracy: float, *, met, undecided) -> Observed:
    """Kinds from the distance of values to the exact ones; `met` tells which rays met what they had to meet."""
    kinds = np.full(len(error), CODE["correct"])
    for name, where in (("wrong value", error > accuracy), ("non-finite", ~np.isfinite(error)), ("missed", ~met),
                        ("undecided", undecided)):
        kinds[where] = CODE[name]
    return Observed(kinds, error)
