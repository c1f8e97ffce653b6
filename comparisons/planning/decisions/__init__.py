"""What is decided, in this order: one file a parameter, each with a function `decide(search)` of decisions.

Each decision is in force as soon as it is made, and every trial after it is judged together with it. Where nothing
changes a decision's `change` is None.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable

from ..search import Decision, Search
from . import cutoff, depth, distance, effects, first_hit, objects, precision, samples, shadows

ORDER: tuple[Callable[[Search], Iterable[Decision]], ...] = (
    objects.decide, effects.decide, samples.decide, cutoff.decide, depth.decide, precision.decide, shadows.decide,
    first_hit.decide, distance.decide)
