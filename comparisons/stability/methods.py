"""The methods under test, by name: those of `reference_tracer.first_hit`, and wrong starts of secondary rays."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import drjit as dr

from raytruth.reference_tracer.backend import Backend
from raytruth.reference_tracer.first_hit import FirstHit, Intersection, LocalRay, Solid
from raytruth.reference_tracer.first_hit.descartes import Descartes
from raytruth.reference_tracer.first_hit.exact import cheapest_exact
from raytruth.reference_tracer.first_hit.interval import IntervalMethod
from raytruth.reference_tracer.first_hit.paper import Paper
from raytruth.reference_tracer.first_hit.proof import Proof
from raytruth.reference_tracer.first_hit.quadratic import Quadratic

MAX_ITERATIONS = 20


@dataclass(frozen=True)
class Setting:
    """What a method is built for."""

    degree: int | None  # of the surface's polynomial; None where it has none
    arrays: Backend
    step: object  # stepSize: a number, or a Float with one entry a ray
    bounded: bool = False  # whether the solid has a box

    @property
    def tolerance(self) -> float:
        return 1e-12 if self.arrays.precision == 64 else 1e-6


@dataclass(frozen=True)
class Method:
    """A first-hit method by name. `build` returns None for surfaces it does not apply to."""

    name: str
    title: str
    build: Callable[[Setting], FirstHit | None]
    claims: bool = False  # that an answer it does not flag is right (in double precision)
    literal: bool = False  # steps through space: its cost grows with the range
    wrong_variant: str = ""  # why it is expected to fail: it is shown for comparison only


def _paper(setting: Setting) -> Paper:
    method = Paper(setting.arrays, 1.0, setting.tolerance, MAX_ITERATIONS)
    method.step_size = setting.arrays.Float(setting.step)  # the rays of one batch may differ in their step
    return method


METHODS = (
    Method("paper", "the document's own: fixed steps, then free Newton", _paper, literal=True),
    Method("quadratic", "closed form, degree one or two",
           lambda s: Quadratic() if s.degree is not None and s.degree <= 2 else None),
    Method("descartes", "Descartes' rule of signs, algebraic surfaces",
           lambda s: Descartes() if s.degree is not None else None),
    Method("interval", "interval arithmetic, rounded to nearest", lambda s: IntervalMethod()),
    Method("proof", "interval arithmetic, outward rounded", lambda s: Proof(), claims=True),
    Method("exact", "the cheapest that misses nothing", lambda s: cheapest_exact(s.degree, s.bounded), claims=True))


class SideFromSign:
    """`base`, told the side of sign f(origin) in place of the inherited one."""

    def __init__(self, base: FirstHit):
        self.base, self.name = base, f"{base.name}, side from f(origin)"

    def first(self, solid: Solid, ray: LocalRay, inside, limit) -> Intersection:
        return self.base.first(solid, ray, solid.inside_at(ray, dr.zeros(type(limit))), limit)


class Offset:
    """`base` from an origin moved along the ray by `epsilon`, with the side of sign f there."""

    def __init__(self, base: FirstHit, epsilon):
        self.base, self.epsilon, self.name = base, epsilon, f"{base.name}, origin moved"

    def first(self, solid: Solid, ray: LocalRay, inside, limit) -> Intersection:
        moved = LocalRay(ray.at(self.epsilon), ray.d)
        crossing = self.base.first(solid, moved, solid.inside_at(ray, self.epsilon), limit - self.epsilon)
        crossing.t += self.epsilon
        return crossing


SIDE_FROM_SIGN = Method(
    "paper, side from f(origin)", "the literal method, the side of a secondary ray read off f at its origin",
    lambda s: SideFromSign(_paper(s)), literal=True,
    wrong_variant="f at a point of the surface is rounding noise: its sign says nothing")


def offset(epsilon: float) -> Method:
    """The literal method with secondary rays that start `epsilon` away from the surface."""
    return Method(f"paper, offset {epsilon:g}", f"the literal method, secondary rays start {epsilon:g} along the ray",
                  lambda s: Offset(_paper(s), s.arrays.constant(epsilon)), literal=True,
                  wrong_variant="a ray that leaves the surface again within the offset jumps over the way out")
