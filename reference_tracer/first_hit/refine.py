"""Root refinement that cannot leave its bracket."""

from __future__ import annotations

import drjit as dr


@dr.syntax
def safeguarded_newton(slope_at, low, high, inside, active, guess, tolerance: float | None = None,
                       most: int = 80):
    """The root in [low, high] of a function that is on side `inside` at low and on the other at high.

    Starts at `guess`, or in the middle where that is not within. Newton's step where it stays inside the bracket and at least halves the previous one, bisection elsewhere
    (rtsafe in Press et al., Numerical Recipes). Stops when a step is below `tolerance` max(1, |t|), 8 units of
    rounding if not given (decision M6), not earlier: a small step is a sign of a small error only near a simple root.
    Returns t and the number of iterations. `slope_at(t)` gives g(t) and g'(t).
    """
    tolerance = tolerance or 8 * dr.epsilon(type(low))
    t = dr.select((guess > low) & (guess < high), guess, 0.5 * (low + high))
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
        active = (g != 0) & (last_step > tolerance * dr.maximum(1, dr.abs(t))) & (iterations < most)
    return t, iterations
