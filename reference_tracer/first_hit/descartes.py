"""First hits of algebraic surfaces: Descartes' rule of signs in the Bernstein basis isolates the first crossing."""

from __future__ import annotations

import math

import drjit as dr

from ..numbers import Polynomial
from .interface import LocalRay, Solid
from .refine import safeguarded_newton
from .segments import Scan, SegmentMethod, beyond_origin

MOST_SEGMENTS = 500
NOISE = 2.0**7  # units of rounding in a Bernstein coefficient, relative to the sum of the terms' absolute values
NEAR = 1e-7  # of a root on the polynomial: the next Newton step squares it
NARROWEST = 2.0**-7  # of the width at which a pair of roots drowns in that rounding, sqrt(NOISE)


class Descartes(SegmentMethod):
    """Walks along the ray polynomial g on segments [u, u + w] of the range in which the ray may meet the solid.

    The number of sign changes among the Bernstein coefficients of g on a segment exceeds the number of its roots there
    by an even number (Descartes; Lane and Riesenfeld 1981, Bounds on a polynomial). None: no crossing; the segment is
    left and w doubled. One: exactly one crossing. More: the segment is cut where the roots seem to part. The first coefficient is g at the segment's
    start; its sign is the side the ray is known to be on. A coefficient smaller than its own rounding decides nothing;
    where that never resolves, the ray is undecided.
    """

    name = "descartes"
    evaluations = 1

    @dr.syntax
    def scan(self, solid: Solid, ray: LocalRay, inside, limit, only_first) -> Scan:
        Float, Bool, UInt = type(limit), dr.mask_t(limit), dr.uint32_array_t(type(limit))
        start, stop = solid.search_range(ray, inside, limit)
        scale = dr.maximum(stop - start, 0)
        a = solid.polynomial(*Polynomial.along(ray.at(start), ray.d * scale)).c  # g in u, t = start + u scale
        rounding = NOISE * dr.epsilon(Float)
        noise = rounding * sum((dr.abs(c) for c in a[1:]), dr.abs(a[0]))
        u, w = dr.zeros(Float, dr.width(scale)), Float(1)
        side = Bool(inside)
        count, segments = UInt(0), UInt(0)
        undecided, guess = Bool(False), Float(u)
        active = scale > 0
        while active:
            w = dr.minimum(w, 1 - u)
            b, certain = _bernstein(a, u, w, noise)
            # A ray that leaves a surface starts there, its origin a rounding error on the wrong side: while g moves
            # back towards the ray's own side, the sign change that brings it there is no crossing.
            recovers = ((b[0] < 0) != side) & ((b[1] < b[0] * (len(a) - 1)) == side)
            variations, end_inside, split = _sign_variations(b, dr.select(recovers, ~side, side))
            narrow = w <= NARROWEST * math.sqrt(rounding)
            none = certain & ((variations == 0) | (recovers & (variations == 1)))
            one = certain & (variations == 1) & ~recovers
            passed = none | (narrow & ~one & (end_inside == side))
            hit = one | (narrow & ~none & (end_inside != side))
            undecided |= narrow & ~none & ~one
            count += dr.select(hit, UInt(1), 0)
            segments += 1
            stays = hit & only_first
            guess = dr.select(stays, u + w * (b[0] / (b[0] - b[len(a) - 1])), guess)
            moves = passed | (hit & ~stays)
            side ^= hit & ~stays
            u = dr.select(moves, u + w, u)
            w = dr.select(moves, 2 * w, dr.select(stays, w, split * w))
            active = ~stays & (u < 1) & (segments < MOST_SEGMENTS)
        undecided |= segments >= MOST_SEGMENTS
        end = dr.minimum(u + w, 1)
        # on the polynomial, a few products each step: f itself, with its roots and quotients, then needs one or two
        at_origin = (start == 0) & (u == 0)
        near, _ = safeguarded_newton(lambda v: _horner(a, v), u, end, inside, only_first & (count > 0),
                                     beyond_origin(guess, u, end, at_origin), NEAR)
        near = beyond_origin(near, u, end, at_origin)
        return Scan(dr.fma(u, scale, start), dr.fma(end, scale, start), dr.fma(near, scale, start), count, undecided,
                    segments)


def _horner(a, u):
    """The value and the slope at u of the polynomial with coefficients `a`."""
    value, slope = a[-1], 0 * a[-1]
    for coefficient in a[-2::-1]:
        slope = dr.fma(slope, u, value)
        value = dr.fma(value, u, coefficient)
    return value, slope


def _bernstein(a, u, w, noise):
    """The Bernstein coefficients of the polynomial `a` on [u, u + w], and whether all signs but the first are certain.

    Coefficient j comes multiplied by the binomial (n over j), so that its weights are whole numbers:
    sum over i of (n-i over j-i) a_i w^i.
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
    b, certain = [shifted[0]], dr.mask_t(w)(True)
    for j in range(1, n + 1):
        value = shifted[j]
        for i in range(j):
            value = dr.fma(shifted[i], math.comb(n - i, j - i), value)
        b.append(value)
        certain &= dr.abs(b[j]) > noise * math.comb(n, j)
    return b, certain


def _sign_variations(b, side):
    """Sign changes among `b`, the first sign taken as `side` (Bool, negative), whether the last one is negative, and
    the share of the segment that lies before the middle between the first and the last change.

    The signs of the coefficients follow those of the polynomial along the segment: between its first and its last
    change is where two roots part best.
    """
    Float, n = type(b[0]), len(b) - 1
    UInt = dr.uint32_array_t(Float)
    variations, negative = UInt(0), side
    first, last = Float(n), Float(1)
    for j, coefficient in enumerate(b[1:], 1):
        changes = (coefficient < 0) != negative
        first = dr.minimum(first, dr.select(changes, Float(j), n))
        last = dr.select(changes, Float(j), last)
        variations += dr.select(changes, UInt(1), 0)
        negative = coefficient < 0
    split = (first + last - 1) / (2 * n)
    return variations, negative, dr.select(variations > 1, split, 0.5)
