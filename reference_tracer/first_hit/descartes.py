"""First hits of algebraic surfaces: Descartes' rule of signs in the Bernstein basis isolates the first crossing."""

from __future__ import annotations

import math
from dataclasses import dataclass

import drjit as dr

from ..numbers import Polynomial
from .interface import Crossing, LocalRay, Solid
from .refine import safeguarded_newton

MOST_SEGMENTS = 500
NOISE = 2.0**7  # units of rounding in a Bernstein coefficient, relative to the sum of the terms' absolute values
NARROWEST = 2.0**-7  # of the width at which a pair of roots drowns in that rounding, sqrt(NOISE)


@dataclass
class _Scan:
    """Where the scan of a ray stopped."""

    t: object  # Float, start of the bracket
    end: object  # Float, end of the bracket
    count: object  # UInt, crossings found
    undecided: object  # Bool
    segments: object  # UInt, segments looked at


class Descartes:
    """Walks along the ray polynomial g on segments [u, u + w] of the range in which the ray may meet the solid.

    The number of sign changes among the Bernstein coefficients of g on a segment exceeds the number of its roots there
    by an even number (Descartes; Lane and Riesenfeld 1981, Bounds on a polynomial). None: no crossing; the segment is
    left and w doubled. One: exactly one crossing. More: w is halved. The first coefficient is g at the segment's
    start; its sign is the side the ray is known to be on. A coefficient smaller than its own rounding decides nothing;
    where that never resolves, the ray is undecided.
    """

    name = "descartes"

    def first(self, solid: Solid, ray: LocalRay, inside, limit) -> Crossing:
        scan = self._scan(solid, ray, inside, limit, only_first=dr.mask_t(limit)(True))
        found = scan.count > 0
        # f itself, not its coefficients, which lose digits: a root of f to the last one
        t, iterations = safeguarded_newton(lambda t: solid.slope_at(ray, t, solid.regular), scan.t, scan.end, inside,
                                           found)
        return Crossing(found, t, t, scan.undecided, scan.segments + 2 * iterations)

    def crossings(self, solid: Solid, ray: LocalRay, inside, limit, only_first):
        scan = self._scan(solid, ray, inside, limit, only_first)
        return scan.count, scan.undecided

    @dr.syntax
    def _scan(self, solid: Solid, ray: LocalRay, inside, limit, only_first) -> _Scan:
        Float, Bool, UInt = type(limit), dr.mask_t(limit), dr.uint32_array_t(type(limit))
        start, stop = solid.search_range(ray, inside, limit)
        scale = dr.maximum(stop - start, 0)
        a = solid.polynomial(*Polynomial.along(ray.at(start), ray.d * scale)).c  # g in u, t = start + u scale
        rounding = NOISE * dr.epsilon(Float)
        noise = rounding * sum((dr.abs(c) for c in a[1:]), dr.abs(a[0]))
        u, w = dr.zeros(Float, dr.width(scale)), Float(1)
        side = Bool(inside)
        count, segments = UInt(0), UInt(0)
        undecided = Bool(False)
        active = scale > 0
        while active:
            w = dr.minimum(w, 1 - u)
            variations, certain, end_inside = _sign_variations(a, u, w, side, noise)
            narrow = w <= NARROWEST * math.sqrt(rounding)
            none, one = certain & (variations == 0), certain & (variations == 1)
            passed = none | (narrow & ~one & (end_inside == side))
            hit = one | (narrow & ~none & (end_inside != side))
            undecided |= narrow & ~none & ~one
            count += dr.select(hit, UInt(1), 0)
            segments += 1
            stays = hit & only_first
            moves = passed | (hit & ~stays)
            side ^= hit & ~stays
            u = dr.select(moves, u + w, u)
            w = dr.select(moves, 2 * w, dr.select(stays, w, 0.5 * w))
            active = ~stays & (u < 1) & (segments < MOST_SEGMENTS)
        undecided |= segments >= MOST_SEGMENTS
        return _Scan(dr.fma(u, scale, start), dr.fma(dr.minimum(u + w, 1), scale, start), count, undecided, segments)


def _sign_variations(a, u, w, side, noise):
    """Sign changes among the Bernstein coefficients of the polynomial `a` on [u, u + w], the first taken as `side`.

    Returns (UInt number, Bool whether every sign is certain, Bool whether the segment's end is inside). Coefficient j
    is computed times the binomial (n over j), from integer weights: b_j = sum_i C(n-i, j-i) a_i w^i.
    """
    n = len(a) - 1
    shifted = list(a)  # Taylor shift: the coefficients about u
    for i in range(n):
        for j in range(n - 1, i - 1, -1):
            shifted[j] = dr.fma(shifted[j + 1], u, shifted[j])
    power = w
    for i in range(1, n + 1):
        shifted[i] = shifted[i] * power  # not in place: the last one is a[n] itself
        power = power * w
    UInt = dr.uint32_array_t(type(w))
    variations, certain, negative = UInt(0), dr.mask_t(w)(True), side
    for j in range(1, n + 1):
        b = sum((shifted[i] * math.comb(n - i, j - i) for i in range(1, j + 1)), shifted[0] * math.comb(n, j))
        now_negative = b < 0
        certain &= dr.abs(b) > noise * math.comb(n, j)
        variations += dr.select(now_negative != negative, UInt(1), 0)
        negative = now_negative
    return variations, certain, negative
