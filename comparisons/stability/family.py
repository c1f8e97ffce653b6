"""What a family of cases is: rays with exact answers, at one surface or through a small scene, and what methods make of
them."""

from __future__ import annotations

import json
import zlib
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, fields
from itertools import groupby
from typing import Protocol

import drjit as dr
import numpy as np

from raytruth.reference_tracer.backend import Backend, backend
from raytruth.reference_tracer.first_hit import LocalRay, Solid
from raytruth.reference_tracer.scene.load import parse_scene
from raytruth.reference_tracer.scene.model import Scene
from raytruth.reference_tracer.tracer.rays import Ray, Sides
from raytruth.reference_tracer.tracer.world import World

from .document import CODE, MOST_EVALUATIONS, NAMES, WRONG, Point
from .methods import Method, Setting

SEED = 20180608  # of every random ray


@dataclass(frozen=True)
class Law:
    """`rate(p)`: the probability that `method` gives an answer of one of `kinds`; None where theory is silent."""

    method: str
    sentence: str
    rate: Callable[[float], float | None]
    kinds: tuple[str, ...] = WRONG


@dataclass(frozen=True)
class About:
    """A family in words and numbers. `values` run from easy to hard."""

    id: str
    title: str
    parameter: str  # what the difficulty p is
    values: tuple[float, ...]
    when: str  # when methods fail
    why: str
    instead: str  # what to use
    single: tuple[float, ...] = ()  # the values at which it also runs in single precision
    labels: tuple[str, ...] = ()  # names of the values, where numbers alone say little
    answerable: bool = True  # whether a first-hit method that claims exactness has to answer for what is wrong here

    @property
    def precisions(self) -> tuple[int, ...]:
        return (64, 32) if self.single else (64,)

    def draws(self, precision: int, count: int) -> Iterator[tuple[float, Draw]]:
        """Every value of p, with the same random numbers for every method, whichever other families run."""
        for value in self.values if precision == 64 else self.single:
            seed = [SEED, zlib.crc32(self.id.encode()), zlib.crc32(repr(float(value)).encode()), precision]
            yield value, Draw(count, np.random.default_rng(seed), precision)


@dataclass
class Draw:
    """A source of random rays: how many, from which generator, in which precision they are stored."""

    count: int
    random: np.random.Generator
    precision: int

    @property
    def single(self) -> bool:
        return self.precision == 32

    def stored(self, v) -> np.ndarray:
        """`v` rounded to the precision under test, so that the exact answer is that of the rays as they are."""
        return np.asarray(v, np.float32).astype(float) if self.single else np.asarray(v, float)

    def uniform(self, low: float, high: float, shape=()) -> np.ndarray:
        return self.random.uniform(low, high, (self.count, *shape))

    def directions(self) -> np.ndarray:
        """Unit vectors without a preferred direction, (count, 3)."""
        return unit(self.random.normal(size=(self.count, 3)))

    def lines(self, impact, distance: float, jitter: float) -> tuple[np.ndarray, np.ndarray]:
        """(o, d) of lines that pass the origin at distance `impact`, from `distance` before their nearest point.

        The start is moved by up to `jitter`, so that the phase of fixed steps is uniform if jitter is a multiple of
        the step.
        """
        d = self.directions()
        across = unit(np.cross(d, self.directions()))
        along = self.uniform(0, jitter) - distance
        return self.stored(across * np.reshape(impact, (-1, 1)) + d * along[:, None]), self.stored(d)

    def along_x(self, start: float, jitter: float, sign: float = 1.0) -> tuple[np.ndarray, np.ndarray]:
        """(o, d) of rays along the x axis that start at x = start - sign U(0, jitter), with y and z at random."""
        o = self.uniform(-1, 1, (3,))
        o[:, 0] = start - sign * self.uniform(0, jitter)
        return self.stored(o), np.tile([sign, 0.0, 0.0], (self.count, 1))


def unit(v) -> np.ndarray:
    return v / np.linalg.norm(v, axis=-1, keepdims=True)


@dataclass
class Outcome:
    """What one method did at one value of p; `example` is the first wrong ray, as numbers that reproduce it."""

    point: Point
    example: dict | None = None


@dataclass
class Observed:
    """What became of n rays: the kind of each (index into NAMES), how far it is off the truth, evaluations of f."""

    kinds: np.ndarray
    error: np.ndarray  # not finite where there is nothing to measure
    evaluations: np.ndarray | None = None

    def outcomes(self, sizes: Sequence[int], example: Callable[[int], dict]) -> list[Outcome]:
        """The outcome of every case of a batch of cases of these sizes; `example` tells of one ray."""
        ends = np.cumsum(sizes)
        return [self._outcome(slice(end - size, end), example) for end, size in zip(ends, sizes)]

    def _outcome(self, rays: slice, example: Callable[[int], dict]) -> Outcome:
        kinds, error = self.kinds[rays], self.error[rays]
        right = error[(kinds == CODE["correct"]) & np.isfinite(error)]
        wrong = np.flatnonzero(np.isin(kinds, [CODE[name] for name in WRONG]))
        counts = np.bincount(kinds, minlength=len(NAMES))
        point = Point(counts={name: int(n) for name, n in zip(NAMES, counts) if n},
                      worst_error=float(right.max()) if len(right) else None,
                      evaluations=None if self.evaluations is None else float(self.evaluations[rays].mean()))
        first = rays.start + int(wrong[0]) if len(wrong) else None
        return Outcome(point, None if first is None else {"kind": NAMES[self.kinds[first]], **example(first)})


class Family(Protocol):
    about: About
    laws: Sequence[Law]
    variants: Sequence[Method]  # wrong variants shown beside the methods

    def cases(self, precision: int, count: int) -> object:
        """The rays of every value of p, and their exact answers."""

    def run(self, cases: object, method: Method, precision: int) -> list[Outcome | None] | None:
        """What `method` does at every value of p; None where it does not apply."""


# --- rays at one surface ----------------------------------------------------------------------------------------------
@dataclass
class Rays:
    """n rays o + t d on (0, limit], the numbers f takes for each of them, and the truth. Arrays of length n, fp64.

    `first` is the exact distance of the first change of side: infinity where there is none, NaN where f is undefined
    on the way, so that the only right answer is "undecided" (decision M7). `others` are further roots on the line.
    """

    o: np.ndarray  # (n, 3)
    d: np.ndarray  # (n, 3)
    inside: np.ndarray  # bool, the side each ray starts on
    limit: np.ndarray
    first: np.ndarray
    others: np.ndarray  # (n, k), infinity where there are fewer
    accuracy: np.ndarray  # |t - first| up to this is correct
    step: np.ndarray  # stepSize of the literal method
    reach: np.ndarray  # where the literal method stops; the others go to `limit`
    parameters: dict[str, np.ndarray]

    @staticmethod
    def of(o, d, *, first, inside=False, limit=6.0, others=None, accuracy=1e-6, step=0.05, reach=None,
           **parameters) -> Rays:
        """Rays from arrays or from single numbers that hold for all of them."""
        n = len(o)
        wide = lambda v, kind=float: np.array(np.broadcast_to(np.asarray(v, kind), (n,)))
        others = np.full((n, 0), np.inf) if others is None else np.reshape(np.asarray(others, float), (n, -1))
        return Rays(np.asarray(o, float), np.asarray(d, float), wide(inside, bool), wide(limit), wide(first), others,
                    wide(accuracy), wide(step), wide(limit if reach is None else reach),
                    {name: wide(v) for name, v in parameters.items()})

    def __len__(self):
        return len(self.o)

    @staticmethod
    def joined(parts: list[Rays]) -> Rays:
        """One batch of all the rays of `parts`, which take the same parameters."""
        most = max(part.others.shape[1] for part in parts)
        pad = lambda v: np.pad(v, ((0, 0), (0, most - v.shape[1])), constant_values=np.inf)
        every = {f.name: [getattr(part, f.name) for part in parts] for f in fields(Rays)}
        every["others"] = [pad(v) for v in every["others"]]
        parameters = every.pop("parameters")
        return Rays(**{name: np.concatenate(values) for name, values in every.items()},
                    parameters={name: np.concatenate([p[name] for p in parameters]) for name in parameters[0]})

    def example(self, i: int) -> dict:
        return {"o": self.o[i].tolist(), "d": self.d[i].tolist(), "inside": bool(self.inside[i]),
                "limit": float(self.limit[i]), "parameters": {k: float(v[i]) for k, v in self.parameters.items()},
                "exact": float(self.first[i])}


@dataclass
class Answer:
    """What a method says of n rays, as NumPy arrays of length n."""

    found: np.ndarray  # bool
    t: np.ndarray  # fp64, meaningful where found
    undecided: np.ndarray  # bool
    evaluations: np.ndarray  # of f


def classify(rays: Rays, answer: Answer) -> np.ndarray:
    """The kind of every answer as an index into NAMES, (n,).

    A flag "undecided" comes first: such an answer claims nothing. Where f is undefined on the way (decision M7) it is
    the only correct answer.
    """
    crosses, undefined = np.isfinite(rays.first), np.isnan(rays.first)
    with np.errstate(invalid="ignore"):
        near = np.abs(answer.t - rays.first) <= rays.accuracy
        elsewhere = np.any(np.abs(answer.t[:, None] - rays.others) <= rays.accuracy[:, None], axis=1)
    off = crosses & answer.found & ~near
    return coded(len(answer.t), ("too slow", answer.evaluations > MOST_EVALUATIONS),
                 ("missed", crosses & ~answer.found), ("false", (~crosses & answer.found) | undefined),
                 ("wrong root", off & elsewhere), ("diverged", off & ~elsewhere),
                 ("non-finite", answer.found & ~np.isfinite(answer.t)), ("undecided", answer.undecided & ~undefined),
                 ("correct", answer.undecided & undefined))


def coded(count: int, *kinds: tuple[str, np.ndarray]) -> np.ndarray:
    """Indices into NAMES, (count,): "correct", but for the kinds and where they are, of which the last counts."""
    code = np.full(count, CODE["correct"])
    for name, where in kinds:
        code[np.broadcast_to(where, count)] = CODE[name]
    return code


@dataclass(frozen=True)
class Shape:
    """The f of a family, on any number type; coordinates first, then parameters by name.

    A parameter is data: the kernels of a family are compiled once for all its values.
    """

    f: Callable
    degree: int | None = None  # of f as a polynomial of the coordinates, or of `polynomial`
    regular: Callable | None = None  # as in Surface.regular_form, where f itself does not serve
    box: Callable | None = None  # parameters -> corners (low, high)

    def solid(self, arrays: Backend, parameters: dict) -> Solid:
        bind = lambda form: lambda x, y, z: form(x, y, z, **parameters)
        box = tuple(arrays.Vector(*corner) for corner in self.box(**parameters)) if self.box else None
        f = bind(self.f)
        return Solid(f, bind(self.regular) if self.regular else f, f if self.degree is not None else None,
                     box, far_inside=arrays.Bool(False))

    def ask(self, rays: Rays, method: Method, precision: int) -> Answer | None:
        """The answers of `method`, or None where it does not apply to the surface."""
        arrays = backend(precision)
        number = lambda v: arrays.Float(np.ascontiguousarray(v))
        vector = lambda v: arrays.Vector(*(number(v[:, k]) for k in range(3)))
        first_hit = method.build(Setting(self.degree, arrays, number(rays.step), self.box is not None))
        if first_hit is None:
            return None
        solid = self.solid(arrays, {name: number(v) for name, v in rays.parameters.items()})
        c = first_hit.first(solid, LocalRay(vector(rays.o), vector(rays.d)), arrays.Bool(rays.inside),
                            number(rays.reach if method.literal else rays.limit))
        dr.eval(c)
        wide = lambda array, kind: np.broadcast_to(array.numpy(), len(rays)).astype(kind)
        return Answer(wide(c.found, bool), wide(c.t, float), wide(c.undecided, bool), wide(c.evaluations, int))

    def run(self, cases: list[Rays], method: Method, precision: int) -> list[Outcome] | None:
        """Runs all `cases` in one launch of one kernel and tells what became of each."""
        rays = Rays.joined(cases)
        answer = self.ask(rays, method, precision)
        if answer is None:
            return None
        with np.errstate(invalid="ignore"):
            error = np.where(answer.found, np.abs(answer.t - rays.first), np.nan)
        return Observed(classify(rays, answer), error, answer.evaluations).outcomes(
            [len(case) for case in cases],
            lambda i: {**rays.example(i), "found": bool(answer.found[i]), "t": float(answer.t[i])})


@dataclass(frozen=True)
class SurfaceFamily:
    """Rays at one surface, asked for their first crossing. All values of p run in one batch."""

    about: About
    shape: Shape
    rays: Callable[[float, Draw], Rays]
    laws: tuple[Law, ...] = ()
    variants: tuple[Method, ...] = ()

    def cases(self, precision: int, count: int) -> list[Rays]:
        return [self.rays(p, draw) for p, draw in self.about.draws(precision, count)]

    def run(self, cases: list[Rays], method: Method, precision: int) -> list[Outcome] | None:
        return self.shape.run(cases, method, precision)


# --- rays through a small scene ---------------------------------------------------------------------------------------
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


@dataclass(frozen=True)
class ModelFamily:
    """Rays through a small scene. `case(p, draw)` gives the rays and the truth, `observe(case, world)` what a method makes
    of them. Values of p that share a scene run in one batch."""

    about: About
    case: Callable[[float, Draw], Case]
    observe: Callable[[Case, World], Observed]
    laws: tuple[Law, ...] = ()
    variants: tuple[Method, ...] = ()
    traced: Callable[[Scene, Method], Scene] = lambda scene, method: scene  # the scene as a variant traces it

    def cases(self, precision: int, count: int) -> list[Case]:
        return [self.case(p, draw) for p, draw in self.about.draws(precision, count)]

    def run(self, cases: list[Case], method: Method, precision: int) -> list[Outcome] | None:
        outcomes = []
        for scene, group in groupby(cases, key=lambda case: case.scene):
            world, batch = world_of(self.traced(scene, method), method, precision), list(group)
            if world is None:
                return None
            case = Case.joined(batch)
            observed = self.observe(case, world)
            outcomes += observed.outcomes([len(c.o) for c in batch], lambda i: {
                "o": case.o[i].tolist(), "d": case.d[i].tolist(), "error": float(observed.error[i])})
        return outcomes


def judged(error: np.ndarray, accuracy: float, *, met, undecided) -> Observed:
    """Kinds from the distance of values to the exact ones; `met` tells which rays met what they had to meet."""
    return Observed(coded(len(error), ("wrong value", error > accuracy), ("non-finite", ~np.isfinite(error)),
                          ("missed", ~met), ("undecided", undecided)), error)
