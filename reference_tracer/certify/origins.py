"""Where a ray starts in relation to a surface, by ball arithmetic."""

from __future__ import annotations

from flint import arb

from ..first_hit.interval import NARROWEST
from ..numbers.exact import Series, rational
from ..surfaces.surface import Surface
from .search import precision

BITS = 128  # of the balls; a float has 53
SHORT = NARROWEST * 2.0**-52  # the length of the first segment that proofs do not divide any more


def starts_on(surface: Surface, o, reach: float) -> bool:
    """Whether the surface may pass within `reach` of `o` (its own frame): f is not certain to have one sign there."""
    with precision(BITS):
        ball = [arb(rational(c)) + (arb(0, reach) if reach else 0) for c in o]
        value = _along(surface, ball, [arb(0)] * 3)[0]
        return not (value > 0 or value < 0)


def starts_along(surface: Surface, o, d) -> bool:
    """Whether f and its slope along the ray may both be zero on the first segment that proofs do not divide any more.

    The ray then starts on the surface and in its tangent plane, or where the gradient vanishes.
    """
    with precision(BITS):
        t = arb(0.5 * SHORT, 0.5 * SHORT)
        value, slope = _along(surface, [arb(rational(a)) + t * arb(rational(b)) for a, b in zip(o, d)], d)
        # where f has no value the ray starts on no surface
        return value.is_finite() and not any(v > 0 or v < 0 for v in (value, slope))


def _along(surface: Surface, point, d) -> tuple[arb, arb]:
    """Balls for f at the points of a ball, and for its slope along d; a NaN has no sign."""
    parameters = {name: Series.constant(value) for name, value in surface.parameters.items()}
    s = surface.regular_form(*Series.along(point, [arb(rational(v)) for v in d], arb(0)), **parameters).s
    return s[0], s[1]
