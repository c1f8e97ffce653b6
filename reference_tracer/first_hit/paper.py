"""The document's own method, literally: fixed steps until a sign changes, then Newton (sections 4.1 and 4.2)."""

from __future__ import annotations

import drjit as dr

from .interface import Intersection, LocalRay, Solid
from .quadratic import Parabola

UNREACHABLE = 1e30  # stands for infinity where steps are counted


class Paper:
    """Steps of `step_size`, then free Newton from the middle of the step in which the sign changed.

    It includes the method's own failures: two crossings within one step are missed, and Newton may leave the step
    (decision M6). Samples whose sign is known are not evaluated, outside of a solid's box or before the root of a plane:
    the result is the same as if they were.
    """

    name = "paper"
    vouches = False
    closed_form = False

    def __init__(self, arrays, step_size: float, tolerance: float, max_iterations: int):
        self.step_size = arrays.constant(step_size)
        self.tolerance = arrays.constant(tolerance)
        self.max_iterations = arrays.count(max_iterations)
        self.variables = self.step_size, self.tolerance, self.max_iterations

    @dr.syntax
    def first(self, solid: Solid, ray: LocalRay, inside, limit) -> Intersection:
        h = self.step_size
        entry, leave = solid.span(ray, limit)
        step = self._steps_skipped(solid, ray, inside, entry, limit)
        t_end = self._end(solid, inside, entry, leave, limit)
        t = dr.minimum(step * h, limit)
        now_inside = type(inside)(inside)
        evaluations = dr.zeros(type(self.max_iterations))
        while (now_inside == inside) & (t < t_end):
            step += 1
            t = dr.minimum(step * h, limit)  # point = r_origin + step * stepSize * r_dir
            now_inside = solid.inside_at(ray, t)
            evaluations += 1
        found = now_inside != inside
        step_end = type(t)(t)

        t = 0.5 * ((step - 1) * h + t)  # t_0 = (step - 0.5) stepSize
        iteration = dr.zeros(type(self.max_iterations))
        active = type(found)(found)
        while active:
            g, slope = solid.slope_at(ray, t)
            dt = g / slope
            finite = dr.isfinite(dt)
            t = dr.select(finite, t - dt, t)  # t_{n+1} = t_n - g(t_n) / g'(t_n)
            iteration += 1
            active = finite & (dr.abs(dt) > self.tolerance * dr.maximum(1, dr.abs(t))) & (iteration < self.max_iterations)
        return Intersection(found, t, step_end, dr.zeros(type(found)), evaluations + 2 * iteration)

    @dr.syntax
    def crossings(self, solid: Solid, ray: LocalRay, inside, limit, only_first):
        h = self.step_size
        entry, leave = solid.span(ray, limit)
        step = self._steps_skipped(solid, ray, inside, entry, limit)
        t = dr.minimum(step * h, limit)
        side = type(inside)(inside)
        count = dr.zeros(type(self.max_iterations))
        counting = type(inside)(True)
        while counting & (t < self._end(solid, side, entry, leave, limit)):
            step += 1
            t = dr.minimum(step * h, limit)
            now_inside = solid.inside_at(ray, t)
            count += dr.select(now_inside != side, 1, 0)
            side = now_inside
            counting = ~(only_first & (count > 0))
        return count, dr.zeros(type(inside))

    def _steps_skipped(self, solid, ray, inside, entry, limit):
        """The number of steps whose signs are known without looking: before the box, or before the root of a parabola.

        One step too few is skipped, so that rounding of entry or root does not matter.
        """
        if solid.box is not None:
            known = dr.select(inside == solid.far_inside, entry, 0)
        elif solid.polynomial is solid.f and (parabola := Parabola.along(solid, ray, limit)):
            known = dr.minimum(parabola.next_crossing(inside), UNREACHABLE)
        else:
            known = dr.zeros(type(entry))
        return dr.maximum(dr.floor(known / self.step_size) - 1, 0)

    @staticmethod
    def _end(solid, inside, entry, leave, limit):
        """Where stepping may stop: past the box the side is known; a ray that is within the solid must come out."""
        if solid.box is None:
            return limit
        return dr.select(inside == solid.far_inside, dr.select(entry <= leave, leave, -1), limit)
