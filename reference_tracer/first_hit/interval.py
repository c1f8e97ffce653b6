"""First hits of any f by interval arithmetic: a segment is left only when it provably holds no crossing."""

from __future__ import annotations

import drjit as dr

from ..numbers import Interval
from .interface import LocalRay, Solid
from .segments import Scan, SegmentMethod, beyond_origin

NARROWEST = 2.0**10  # units of rounding; the relative width below which a segment is not divided any more
MOST_SEGMENTS = 20_000


class IntervalMethod(SegmentMethod):
    """Looks at segments [t, t + w] front to back, doubling w after a segment without crossing and halving it otherwise.

    A segment holds no crossing if an enclosure of g excludes zero, or if g' does (g is monotone) and the end is still
    on the ray's side; it holds exactly one if g is monotone and the end is on the other side (Moore 1966; Mitchell
    1990, Robust ray intersection with interval arithmetic). Beside the natural enclosure of g the lines of slope
    inf g' and sup g' through both ends bound it, an enclosure whose excess falls with w^2 (linear boundary value form,
    Neumaier 1990).
    """

    name = "interval"
    number: type[Interval] = Interval
    evaluations = 3

    @dr.syntax
    def scan(self, solid: Solid, ray: LocalRay, inside, limit, only_first) -> Scan:
        Float, Bool, UInt = type(limit), dr.mask_t(limit), dr.uint32_array_t(type(limit))
        start, stop = solid.search_range(ray, inside, limit)
        t, end, w = Float(start), Float(start), stop - start
        side = Bool(inside)
        g_start = dr.select(start > 0, solid.regular(*ray.at(start)), 0)  # at the origin g is noise; its side is known
        count, segments, undecided, guess = UInt(0), UInt(0), Bool(False), Float(start)
        active = t < stop
        while active:
            w = dr.minimum(w, stop - t)
            end = dr.select(t + w >= stop, stop, t + w)
            w = end - t
            g, slope = solid.enclose(ray, t, end, self.number)
            g_end, end_inside, end_outside = self._end_of_segment(solid, ray, end)
            crossed = dr.select(side, end_outside, end_inside)
            stayed = dr.select(side, end_inside, end_outside)
            # where g may not be finite (M7), neither its slope nor its ends say anything
            known = dr.isfinite(g.low) & dr.isfinite(g.high)
            rises, falls = known & (slope.low > 0), known & (slope.high < 0)
            simple = rises | falls | (known & (g.excludes_zero() | self._bounded_away(g_start, g_end, slope, w, side)))
            # g moves away from zero on the ray's own side: whatever the signs, there is no crossing. A ray that leaves
            # a surface starts there, its origin a rounding error on the wrong side.
            recovers = dr.select(side, falls, rises)
            narrow = w <= NARROWEST * dr.epsilon(Float) * dr.maximum(1, dr.abs(t))
            clean = recovers | (stayed & simple)
            hit = ~clean & crossed & (simple | narrow)
            passed = clean | (narrow & ~hit)
            # narrow, yet neither excluded nor crossed: two crossings closer than NARROWEST may hide here
            undecided |= (passed & ~clean) | (hit & ~known)
            count += dr.select(hit, UInt(1), 0)
            segments += 1
            stays = hit & only_first
            guess = dr.select(stays, t + w * (g_start / (g_start - g_end)), guess)
            moves = passed | (hit & ~stays)
            side ^= hit & ~stays
            t = dr.select(moves, end, t)
            g_start = dr.select(moves, g_end, g_start)
            w = dr.select(moves, 2 * w, dr.select(stays, w, 0.5 * w))
            active = ~stays & ~(narrow & ~known) & (t < stop) & (segments < MOST_SEGMENTS)
        undecided |= segments >= MOST_SEGMENTS
        guess = beyond_origin(guess, t, end, t == 0)
        return Scan(t, end, guess, count, undecided, segments)

    def _end_of_segment(self, solid: Solid, ray: LocalRay, end):
        """g at `end`, whether that point is inside, and whether it is outside."""
        g = solid.regular(*ray.at(end))
        return g, g < 0, ~(g < 0)

    def _bounded_away(self, g_start, g_end, slope: Interval, w, side):
        """Whether the lines of extreme slope through both ends keep g off zero, on the side the ray is on.

        With g >= 0 on that side (else negate): left of the lines' meeting g >= g0 + s_lo u, right of it
        g >= g1 - s_hi (w - u); their meeting is the lowest point, (s_hi g0 - s_lo g1 + w s_lo s_hi) / (s_hi - s_lo).
        """
        sign = dr.select(side, -1, 1)
        g0, g1 = sign * g_start, sign * g_end
        low = dr.select(side, -slope.high, slope.low)
        high = dr.select(side, -slope.low, slope.high)
        # the products below are finite only for finite slopes; an infinite one makes NaN, which proves nothing
        return (g0 > 0) & (g1 > 0) & (high * g0 - low * g1 + w * low * high > 0) & (low < 0) & (high > 0)
