"""What is decided, in this order: one file a parameter, each with a function `decide(search) -> Decision`.

Where nothing changes the decision's `change` is None. A decision never makes a picture dearer, so that a later one
may rely on the earlier ones.
"""

from __future__ import annotations

from collections.abc import Callable

from ..search import Decision, Search
from . import cutoff, depth, distance, effects, first_hit, objects, precision, samples, shadows

ORDER: tuple[Callable[[Search], list[Decision]], ...] = (
    objects.decide, effects.decide, cutoff.decide, depth.decide, precision.decide, shadows.decide, first_hit.decide,
    samples.decide, distance.decide)
