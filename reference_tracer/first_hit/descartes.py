"""First hits of algebraic surfaces: Descartes' rule of signs in the Bernstein basis isolates the first crossing."""

from __future__ import annotations

import math
from functools import partial

import drjit as dr

from ..numbers import OfDegree, Polynomial
from .interface import LocalRay, Solid
from .refine import safeguarded_newton
from .segments import Scan, SegmentMethod, beyond_origin

MOST_SEGMENTS = 500
# Units of rounding in a Bernstein coefficient, relative to the sum of the |a_i| and to its binomial. The coefficient is a
# sum of products of a_i with weights that are those of the blossom of t^i in [0, 1], at most 1; a path through
# `_bernstein` rounds at most 3 n + 1 times by half a unit, 13 units for n = 8 (Higham, Accuracy and Stability of Numerical
# Algorithms, 2002, lemma 3.1). The rest is for the a_i themselves, which are sums of products as well.
NOISE = 2.0**7
NEAR = 1e-7  # of a root on the polynomial: the next Newton step squares it
NARROWEST = 2.0**-7  # of the width at which a pair of roots drowns in that rounding; narrower ones are undecided


class Descartes(SegmentMethod):
    """Walks along the ray polynomial g on segments [u, u + w] of the range in which the ray may meet the solid.

    The number of sign changes among the Bernstein coefficients of g on a segment exceeds the number of its roots there
    by an even number (Descartes; Lane and Riesenfeld 1981, Bounds on a polynomial). None: no crossing; the segment is
    left and w doubled. One: exactly one crossing. More: the segment is cut where the roots seem to part. The first
    coefficient is g at the segment's start; once g has been seen on the ray's own side (`settled`) its sign is that
    side. A coefficient smaller than its own rounding decides nothing; where that never resolves, the ray is undecided.

    At the ray's origin the first coefficient is noise (see IntervalMethod), and the others must tell: where all are on
    the own side g arrives there, and what it may have passed is the surface the ray starts on. Anything else decides
    nothing.
    """

    name = "descartes"
    evaluations = 1

    @dr.syntax
    def scan(self, solid: Solid, ray: LocalRay, inside, limit, only_first, refine: bool) -> Scan:
        Float, Bool, UInt = type(limit), dr.mask_t(limit), dr.uint32_array_t(type(limit))
        start, stop = solid.search_range(ray, inside, limit)
        scale = dr.maximum(stop - start, 0)
        polynomial = solid.polynomial(*Polynomial.along(ray.at(start), ray.d * scale))  # g in u, t = start + u scale
        look = partial(_looked_at, polynomial)
        a, rounding = polynomial.c, NOISE * dr.epsilon(Float)
        noise = rounding * sum((dr.abs(c) for c in a[1:]), dr.abs(a[0]))
        known = dr.isfinite(noise)
        u, w = dr.zeros(Float, dr.width(scale)), Float(1)
        side = Bool(inside)
        settled = (start > 0) | dr.select(side, a[0] < -noise, a[0] > noise)
        count, segments = UInt(0), UInt(0)
        undecided, guess = ~known, Float(u)
        active = known & (scale > 0)
        while active:
            w = dr.minimum(w, 1 - u)
            first, last, certain, variations, end_inside, split = look(u, w, noise, settled, side)
            narrow = w <= NARROWEST * math.sqrt(rounding)
            none = certain & (variations == 0) & (settled | (end_inside == side))
            one = certain & (variations == 1) & settled
            hit = one | (narrow & ~none & (end_inside != side))
            passed = none | (narrow & ~hit)
            undecided |= narrow & ~none & ~one
            count += dr.select(hit, UInt(1), 0)
            segments += 1
            stays = hit & only_first
            guess = dr.select(stays, u + w * (first / (first - last)), guess)
            moves = passed | (hit & ~stays)
            side ^= hit & ~stays
            settled |= moves
            u = dr.select(moves, u + w, u)
            w = dr.select(moves, 2 * w, dr.select(stays, w, split * w))
            active = ~stays & (u < 1) & (segments < MOST_SEGMENTS)
        undecided |= segments >= MOST_SEGMENTS
        end = dr.minimum(u + w, 1)
        # on the polynomial, a few products each step: f itself, with its roots and quotients, then needs one or two
        at_origin = (start == 0) & (u == 0)
        near, _, _ = safeguarded_newton(lambda v: _horner(a, v), u, end, inside, only_first & (count > 0),
                                     beyond_origin(guess, u, end, at_origin), NEAR)
        near = beyond_origin(near, u, end, at_origin)
        return Scan(dr.fma(u, scale, start), dr.fma(end, scale, start), dr.fma(near, scale, start), Bool(True), count,
                    undecided, segments)

    def _makes_sure(self, solid, ray, inside, t, scan, doubtful):
        return ~doubtful  # a cascade has intervals for these


def _horner(a, u):
    """The value and the slope at u of the polynomial with coefficients `a`."""
    value, slope = a[-1], 0 * a[-1]
    for coefficient in a[-2::-1]:
        slope = dr.fma(slope, u, value)
        value = dr.fma(value, u, coefficient)
    return value, slope


def _looked_at(polynomial, u, w, noise, settled, side):
    """What the Bernstein coefficients on [u, u + w] tell: the first and the last of them, whether their signs are certain,
    and the sign variations."""
    def look(a, *segment):
        settled, side, u, w, noise = segment
        b, certain = _bernstein(a, u, w, noise)
        return b[0], b[-1], certain, *_sign_variations(b, dr.select(settled, side, b[1] < 0))

    segment = settled, side, u, w, noise  # dr.switch takes a Bool at the end for its mask
    if not isinstance(polynomial, OfDegree):
        return look(polynomial.c, *segment)
    looks = [lambda a, *segment, n=n: look(a[:n + 1], *segment) for n in range(1, polynomial.degree + 1)]
    return dr.switch(polynomial.actual - 1, looks, list(polynomial.c), *segment)


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
