"""Root refinement that cannot leave its bracket."""

from __future__ import annotations

import math

import drjit as dr


@dr.syntax
def safeguarded_newton(slope_at, low, high, inside, active, most: int = 80):
    """The root in [low, high] of a function that is on side `inside` at low and on the other at high.

    Newton's step where it stays inside the bracket and at least halves the previous one, bisection elsewhere
    (rtsafe in Press et al., Numerical Recipes). Stops when a step is below 8 units of rounding of
    max(1, |t|) (decision M6), or when a Newton step is below half their root: the next one would be below them,
    because the error is squared. Returns t and the number of iterations. `slope_at(t)` gives g(t) and g'(t).
    """
    tolerance = 8 * dr.epsilon(type(low))
    newton_tolerance = 0.5 * math.sqrt(dr.epsilon(type(low)))
    t = 0.5 * (low + high)
    low, high = type(t)(low), type(t)(high)
    last_step = high - low
    iterations = dr.zeros(dr.uint32_array_t(type(t)))
    active = dr.mask_t(t)(active)
    while active:
        g, slope = slope_at(t)
        before = (g < 0) == inside  # t still lies on the starting side
        low = dr.select(before, t, low)
        high = dr.select(before, high, t)
        newton = t - g / slope
        accept = (newton >= low) & (newton <= high) & (dr.abs(newton - t) <= 0.5 * last_step)
        candidate = dr.select(accept, newton, 0.5 * (low + high))
        last_step = dr.abs(candidate - t)
        t = dr.select(g == 0, t, candidate)
        iterations += 1
        enough = dr.select(accept, newton_tolerance, tolerance) * dr.maximum(1, dr.abs(t))
        active = (g != 0) & (last_step > enough) & (iterations < most)
    return t, iterations
