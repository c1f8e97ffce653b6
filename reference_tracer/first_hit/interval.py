"""First hits of any f by interval arithmetic: a segment is left only when it provably holds no crossing."""

from __future__ import annotations

import drjit as dr

from ..numbers import Interval
from .interface import LocalRay, Solid
from .segments import Scan, SegmentMethod, beyond_origin

# Relative width below which a segment is not divided any more. Rounding moves the points of a ray by 2 units: segments
# of 2^10 hold every point that is meant by their ends, and their enclosures exceed what rounding does to f there. No
# verdict hangs on it: what is neither excluded nor crossed on so narrow a segment is undecided.
NARROWEST = 2.0**10
MOST_SEGMENTS = 20_000


class IntervalMethod(SegmentMethod):
    """Looks at segments [t, t + w] front to back, doubling w after a segment without crossing and halving it otherwise.

    A segment holds no crossing if an enclosure of g excludes zero, or if g' does (g is monotone) and the end is still
    on the ray's side; it holds exactly one if g is monotone and the end is on the other side (Moore 1966; Mitchell
    1990, Robust ray intersection with interval arithmetic). Beside the natural enclosure of g the lines of slope
    inf g' and sup g' through both ends bound it, an enclosure whose excess falls with w^2 (linear boundary value form,
    Neumaier 1990).

    The side a ray starts on is told, not seen: its origin may lie a rounding error, or at a multiple root far more, on
    the other side of the surface it leaves. Until g has been seen on the ray's own side (`settled`; outside of the
    solid's box it is) only what holds on both sides of the root is concluded: g runs to the own side and has arrived at
    the end, so that what it may have passed is the surface the ray starts on; or g runs away from it and the end is on
    the other side, so that the ray has left its side. Where g runs towards the own side but stays on the other all
    along, the origin is on the wrong side for certain, and the root ahead is the surface the ray starts on: it is
    skipped (certify/line.py defines all three).
    """

    name = "interval"
    number: type[Interval] = Interval
    evaluations = 3

    @dr.syntax
    def scan(self, solid: Solid, ray: LocalRay, inside, limit, only_first, refine: bool) -> Scan:
        Float, Bool, UInt = type(limit), dr.mask_t(limit), dr.uint32_array_t(type(limit))
        start, stop = solid.search_range(ray, inside, limit)
        t, end, w = Float(start), Float(start), stop - start
        side, settled, skips = Bool(inside), start > 0, Bool(False)
        g_start = dr.select(settled, self._end_of_segment(solid, ray, start)[0], 0)  # at the origin g is noise
        count, segments, undecided, guess = UInt(0), UInt(0), Bool(False), Float(start)
        narrowest, doubtful, regular = Float(NARROWEST * dr.epsilon(Float)), Bool(False), Bool(True)
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
            simple = rises | falls | (known & (g.excludes_zero()
                                               | (settled & self._bounded_away(g_start, g_end, slope, w, side))))
            returns, leaves = dr.select(side, falls, rises), dr.select(side, rises, falls)
            narrow = w <= narrowest * dr.maximum(1, dr.abs(t))
            clean = (stayed & simple) | (returns & settled)
            wrong_start = ~settled & returns & crossed
            hit = ~clean & crossed & (leaves | (settled & (simple | narrow)))
            passed = clean | wrong_start | (narrow & ~hit)
            # narrow, yet neither excluded nor crossed: two crossings closer than NARROWEST may hide here
            lost = (passed & ~clean & ~wrong_start) | (hit & ~known)
            undecided |= lost
            narrowest = dr.select(lost, 2 * narrowest, narrowest)  # what is undecided is guessed in larger steps
            # signs that are noise made this crossing, unless g is clear of zero behind it
            doubtful = (doubtful | (hit & ~simple)) & ~clean
            count += dr.select(hit & ~skips, UInt(1), 0)
            segments += 1
            stays = hit & ~skips & only_first & (simple | refine)
            # a jump of g is a crossing (M1), but f has no gradient there, and the surface that ends so no normal
            undecided |= stays & refine & ~(slope.low <= slope.high)
            regular &= simple | ~stays
            guess = dr.select(stays, t + w * (g_start / (g_start - g_end)), guess)
            moves = passed | (hit & ~stays)
            side ^= (hit & ~stays) | wrong_start
            skips = (skips & ~hit) | wrong_start
            settled |= clean | wrong_start | hit
            t = dr.select(moves, end, t)
            g_start = dr.select(moves, g_end, g_start)
            w = dr.select(moves, 2 * w, dr.select(stays, w, 0.5 * w))
            active = (~stays & ~(narrow & ~known) & ~(only_first & clean & (count > 0)) & (t < stop)
                      & (segments < MOST_SEGMENTS))
        undecided |= (segments >= MOST_SEGMENTS) | skips | (doubtful & (not refine))
        guess = beyond_origin(guess, t, end, t == 0)
        return Scan(t, end, guess, regular, count, undecided, segments)

    def _end_of_segment(self, solid: Solid, ray: LocalRay, end):
        """g at `end`, or a number of less size and the same sign; whether that point is inside, whether outside."""
        g = solid.regular(*ray.at(end))
        return g, g < 0, ~(g < 0)

    def _bounded_away(self, g_start, g_end, slope: Interval, w, side):
        """Whether the lines of extreme slope through both ends keep g off zero, on the side the ray is on.

        With g >= 0 on that side (else negate): left of the lines' meeting g >= g0 + s_lo u, right of it
        g >= g1 - s_hi (w - u); their meeting is the lowest point, (s_hi g0 - s_lo g1 + w s_lo s_hi) / (s_hi - s_lo).
        """
        n = self.number
        sign = dr.select(side, -1, 1)
        g0, g1 = sign * g_start, sign * g_end
        low = dr.select(side, -slope.high, slope.low)
        high = dr.select(side, -slope.low, slope.high)
        # the products below are finite only for finite slopes; an infinite one makes NaN, which proves nothing
        lowest = n(high) * g0 - n(low) * g1 + n.rounded(w, w) * low * high
        return (g0 > 0) & (g1 > 0) & (lowest.low > 0) & (low < 0) & (high > 0)
