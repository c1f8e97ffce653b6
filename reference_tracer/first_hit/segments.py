"""What methods share that walk along a ray in segments: isolate a crossing first, refine it then."""

from __future__ import annotations

import math
from dataclasses import dataclass

import drjit as dr

from .interface import Crossing, LocalRay, Solid
from .refine import safeguarded_newton


@dataclass
class Scan:
    """Where the walk along a ray stopped."""

    t: object  # Float, start of the bracket
    end: object  # Float, end of the bracket
    guess: object  # Float, about where the crossing is; NaN where nothing is known of it
    count: object  # UInt, crossings found
    undecided: object  # Bool
    segments: object  # UInt, segments looked at


def beyond_origin(guess, low, high, at_origin):
    """`guess`, but NaN close to the ray's origin: there lies the surface it may just have left, and signs are noise."""
    return dr.select(~at_origin | (guess > low + (high - low) / 16), guess, dr.nan)


class SegmentMethod:
    """First hits and crossings from `scan`, which a subclass gives."""

    evaluations: int  # of f, for each segment
    vouches = True
    closed_form = False
    variables = ()

    def scan(self, solid: Solid, ray: LocalRay, inside, limit, only_first) -> Scan:
        """Walks along (0, limit] to the bracket of the first crossing, or past all where not `only_first`."""
        raise NotImplementedError

    def first(self, solid: Solid, ray: LocalRay, inside, limit) -> Crossing:
        scan = self.scan(solid, ray, inside, limit, only_first=dr.mask_t(limit)(True))
        found = scan.count > 0
        # on f itself, or its regular form, whatever the bracket was found with: a root of f to the last digit
        t, iterations = safeguarded_newton(lambda t: solid.slope_at(ray, t, solid.regular), scan.t, scan.end, inside,
                                           found, scan.guess)
        # where f is still zero a good way behind the root it has underflowed: its sign says nothing
        step = math.sqrt(dr.epsilon(type(t))) * dr.maximum(1, dr.abs(t))
        flat = dr.if_stmt((), found, lambda: solid.regular(*ray.at(t + step)) == 0, lambda: dr.mask_t(t)(False))
        return Crossing(found, t, t, scan.undecided | flat, self.evaluations * scan.segments + 2 * iterations + 1)

    def crossings(self, solid: Solid, ray: LocalRay, inside, limit, only_first):
        scan = self.scan(solid, ray, inside, limit, only_first)
        return scan.count, scan.undecided
