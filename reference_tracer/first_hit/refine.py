"""Root refinement that cannot leave its bracket."""

from __future__ import annotations

import drjit as dr

# Ends lanes whose steps never get small, as where g is not finite. No verdict hangs on it: that t is the crossing is made
# sure of afterwards (segments.py).
MOST_ITERATIONS = 80


@dr.syntax
def safeguarded_newton(slope_at, low, high, inside, active, guess, tolerance: float | None = None,
                       simple=True):
    """The root in [low, high] of a function that is on side `inside` at low and on the other at high.

    Starts at `guess`, or in the middle where that is not within. Newton's step where it stays inside the bracket and at
    least halves the previous one, bisection elsewhere (rtsafe in Press et al., Numerical Recipes). Stops when a step is
    below `tolerance` max(1, |t|), 8 units of rounding if not given (decision M6). At a root of multiplicity m Newton's
    step is the m-th part of the error: where the root may not be `simple` (Bool) only bisection is trusted, whose step
    is as long as the bracket. Returns t, g one step before, and the number of iterations. `slope_at(t)` gives g(t) and
    g'(t).
    """
    tolerance = tolerance or 8 * dr.epsilon(type(low))
    t = dr.select((guess > low) & (guess < high), guess, 0.5 * (low + high))
    low, high = type(t)(low), type(t)(high)
    last_step, g = high - low, dr.zeros(type(t))
    iterations = dr.zeros(dr.uint32_array_t(type(t)))
    active = dr.mask_t(t)(active)
    while active:
        g, slope = slope_at(t)
        before = (g < 0) == inside  # t still lies on the starting side
        low = dr.select(before, t, low)
        high = dr.select(before, high, t)
        newton = t - g / slope
        accept = simple & (newton >= low) & (newton <= high) & (dr.abs(newton - t) <= 0.5 * last_step)
        candidate = dr.select(accept, newton, 0.5 * (low + high))
        last_step = dr.abs(candidate - t)
        t = dr.select(g == 0, t, candidate)
        iterations += 1
        active = (g != 0) & (last_step > tolerance * dr.maximum(1, dr.abs(t))) & (iterations < MOST_ITERATIONS)
    return t, g, iterations
