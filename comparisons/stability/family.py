"""What a family of cases is, and how the families of single surfaces are run."""

from __future__ import annotations

import zlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Protocol

import drjit as dr
import numpy as np

from reference_tracer.backend import Backend, backend
from reference_tracer.first_hit import LocalRay, Solid

from .law import Law
from .methods import Method, Setting
from .outcome import CODE, NAMES, WRONG, Answer, classify
from .rays import Draw, Rays

SEED = 20180608  # of every random ray


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

    def values_in(self, precision: int) -> tuple[float, ...]:
        return self.values if precision == 64 else self.single

    @property
    def precisions(self) -> tuple[int, ...]:
        return (64, 32) if self.single else (64,)

    def draw(self, value: float, precision: int, count: int) -> Draw:
        """The same random numbers for every method, whichever other families run."""
        seed = [SEED, zlib.crc32(self.id.encode()), zlib.crc32(repr(float(value)).encode()), precision]
        return Draw(count, np.random.default_rng(seed), precision)


@dataclass
class Outcome:
    """What one method did at one value of p."""

    counts: dict[str, int]  # kinds that occurred
    worst_error: float | None  # largest |t - exact| among correct answers that found something
    evaluations: float | None  # of f, mean of a ray
    example: dict | None = None  # the first wrong ray, as numbers that reproduce it


class Family(Protocol):
    about: About
    laws: Sequence[Law]
    variants: Sequence[Method]  # wrong variants shown beside the methods

    def cases(self, precision: int, count: int) -> object:
        """The rays of every value of p, and their exact answers."""

    def run(self, cases: object, method: Method, precision: int) -> list[Outcome] | None:
        """What `method` does at every value of p; None where it does not apply."""


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
        box = None
        if self.box:
            box = tuple(arrays.Vector(*corner) for corner in self.box(**parameters))
        f = bind(self.f)
        return Solid(f, bind(self.regular) if self.regular else f, f if self.degree is not None else None,
                     box, far_inside=arrays.Bool(False))


@dataclass(frozen=True)
class SurfaceFamily:
    """Rays at one surface, asked for their first crossing. All values of p run in one batch."""

    about: About
    shape: Shape
    rays: Callable[[float, Draw], Rays]
    laws: tuple[Law, ...] = ()
    variants: tuple[Method, ...] = ()

    def cases(self, precision: int, count: int) -> list[Rays]:
        return [self.rays(p, self.about.draw(p, precision, count)) for p in self.about.values_in(precision)]

    def run(self, cases: list[Rays], method: Method, precision: int) -> list[Outcome] | None:
        return run_batch(self.shape, cases, method, precision)


def run_batch(shape: Shape, cases: list[Rays], method: Method, precision: int) -> list[Outcome] | None:
    """Runs all `cases` in one launch of one kernel and tells what became of each."""
    rays = Rays.joined(cases)
    answer = ask(shape, rays, method, precision)
    if answer is None:
        return None
    kinds = classify(rays, answer)
    ends = np.cumsum([len(case) for case in cases])
    return [_outcome(rays, answer, kinds, np.arange(end - len(case), end)) for case, end in zip(cases, ends)]


def ask(shape: Shape, rays: Rays, method: Method, precision: int) -> Answer | None:
    """The answers of `method`, or None where it does not apply to the surface."""
    arrays = backend(precision)
    number = lambda v: arrays.Float(np.ascontiguousarray(v))
    vector = lambda v: arrays.Vector(*(number(v[:, k]) for k in range(3)))
    first_hit = method.build(Setting(shape.degree, arrays, number(rays.step), shape.box is not None))
    if first_hit is None:
        return None
    solid = shape.solid(arrays, {name: number(v) for name, v in rays.parameters.items()})
    ray = LocalRay(vector(rays.o), vector(rays.d))
    limit = number(rays.reach if method.literal else rays.limit)
    c = first_hit.first(solid, ray, arrays.Bool(rays.inside), limit)
    dr.eval(c)
    wide = lambda array, kind: np.broadcast_to(array.numpy(), len(rays)).astype(kind)
    return Answer(wide(c.found, bool), wide(c.t, float), wide(c.undecided, bool), wide(c.evaluations, int))


def counted(kinds: np.ndarray) -> dict[str, int]:
    """How often each kind occurs, for those that do."""
    counts = np.bincount(kinds, minlength=len(NAMES))
    return {name: int(n) for name, n in zip(NAMES, counts) if n}


def _outcome(rays: Rays, answer: Answer, kinds: np.ndarray, which: np.ndarray) -> Outcome:
    found = which[(kinds[which] == CODE["correct"]) & answer.found[which] & np.isfinite(rays.first[which])]
    error = float(np.abs(answer.t[found] - rays.first[found]).max()) if len(found) else None
    wrong = which[np.isin(kinds[which], [CODE[name] for name in WRONG])]
    return Outcome(counted(kinds[which]), error, float(answer.evaluations[which].mean()),
                   _example(rays, answer, kinds, int(wrong[0])) if len(wrong) else None)


def _example(rays: Rays, answer: Answer, kinds: np.ndarray, i: int) -> dict:
    return {"kind": NAMES[kinds[i]], "o": rays.o[i].tolist(), "d": rays.d[i].tolist(), "inside": bool(rays.inside[i]),
            "limit": float(rays.limit[i]), "parameters": {k: float(v[i]) for k, v in rays.parameters.items()},
            "exact": float(rays.first[i]), "found": bool(answer.found[i]), "t": float(answer.t[i])}
