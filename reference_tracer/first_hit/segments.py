"""What methods share that walk along a ray in segments: isolate a crossing first, refine it then."""

from __future__ import annotations

import math
from dataclasses import dataclass

import drjit as dr

from .interface import Intersection, LocalRay, Solid
from .refine import safeguarded_newton


@dataclass
class Scan:
    """Where the walk along a ray stopped."""

    t: object  # Float, start of the bracket
    end: object  # Float, end of the bracket
    guess: object  # Float, about where the crossing is; NaN where nothing is known of it
    simple: object  # Bool, g is monotone on the bracket or has one root there, counted with its multiplicity
    count: object  # UInt, crossings found
    undecided: object  # Bool
    segments: object  # UInt, segments looked at


def beyond_origin(guess, low, high, at_origin):
    """`guess`, but NaN close to the ray's origin: there lies the surface it may just have left, and signs are noise."""
    return dr.select(~at_origin | (guess > low + (high - low) / 16), guess, dr.nan)

CLEAR = 2.0**10  # how much larger g is within `resolution` of a root than at it where that is none of rounding's making


def resolution(t):
    """How well a crossing at t must be known to be one: half of the digits of a float.

    Simple roots are known to nearly all of them. At a root of multiplicity m it is the m-th part, less than half from
    m = 3 on (Wilkinson, Rounding Errors in Algebraic Processes, 1963).
    """
    return math.sqrt(dr.epsilon(type(t))) * dr.maximum(1, dr.abs(t))


class SegmentMethod:
    """First hits and crossings from `scan`, which a subclass gives."""

    evaluations: int  # of f, for each segment
    vouches = True
    closed_form = False
    variables = ()

    def scan(self, solid: Solid, ray: LocalRay, inside, limit, only_first, refine: bool) -> Scan:
        """Walks along (0, limit] past all crossings, or past the first where `only_first` holds.

        With `refine` it stops at the bracket of the first one, which `first` then makes sure of.
        """
        raise NotImplementedError

    def first(self, solid: Solid, ray: LocalRay, inside, limit) -> Intersection:
        scan = self.scan(solid, ray, inside, limit, dr.mask_t(limit)(True), refine=True)
        found = scan.count > 0
        # on f itself, or its regular form, whatever the bracket was found with: a root of f to the last digit
        t, g, iterations = safeguarded_newton(lambda t: solid.slope_at(ray, t, solid.regular), scan.t, scan.end, inside,
                                              found, scan.guess, simple=scan.simple)
        # a good way behind a simple root g is far larger than at it; elsewhere rounding may hide where the root is
        behind = dr.if_stmt((), found, lambda: solid.regular(*ray.at(t + resolution(t))), lambda: dr.zeros(type(t)))
        clear = scan.simple & ((behind < 0) != inside) & (dr.abs(behind) > CLEAR * dr.abs(g)) & dr.isfinite(behind)
        sure = self._makes_sure(solid, ray, inside, t, scan, found & ~clear)
        return Intersection(found, t, t, scan.undecided | ~sure, self.evaluations * scan.segments + 2 * iterations + 1)

    def _makes_sure(self, solid: Solid, ray: LocalRay, inside, t, scan: Scan, doubtful):
        """Whether the crossing is at t, where that is `doubtful`; true elsewhere (Bool)."""
        return dr.if_stmt((), doubtful, lambda: self._encloses(solid, ray, inside, t, scan),
                          lambda: dr.mask_t(t)(True))

    @staticmethod
    @dr.syntax
    def _encloses(solid: Solid, ray: LocalRay, inside, t, scan: Scan):
        """Whether g is certainly on side `inside` at t - r and on the other at t + r, within the bracket (Bool).

        Else rounding hides where the crossing is: at a multiple root, where f has underflowed, or where it is a small
        difference of large numbers.
        """
        r = resolution(t)
        point, side, sure = dr.maximum(t - r, 0), dr.mask_t(t)(inside), dr.mask_t(t)(True)
        sides_seen = dr.zeros(dr.uint32_array_t(type(t)))
        while sides_seen < 2:  # f stands in the kernel once
            g = solid.value(ray, point)
            sure &= dr.select(side, g.high < 0, g.low > 0) | ((sides_seen == 0) & (t <= r))
            point, side = dr.minimum(t + r, scan.end), ~side
            sides_seen += 1
        return sure

    def crossings(self, solid: Solid, ray: LocalRay, inside, limit, only_first):
        scan = self.scan(solid, ray, inside, limit, only_first, refine=False)
        return scan.count, scan.undecided
