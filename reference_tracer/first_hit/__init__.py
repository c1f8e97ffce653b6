"""First-hit methods: given f, rays, a range and the side each ray is on, where does it first change side?

One file a method, all on the interface of `interface.py`; `choose` maps a method's name to the method for a surface.
"""

from __future__ import annotations

from ..errors import InputError
from .exact import cheapest_exact
from .interface import Crossing, FirstHit, LocalRay, Solid
from .interval import IntervalMethod
from .paper import Paper

METHODS = {
    "paper": "the document's own: fixed steps, then free Newton; includes its failures",
    "exact": "misses nothing: closed forms for degree <= 2, interval arithmetic for the rest",
    "interval": "interval arithmetic for every surface",
}


def choose(method: str, surface, tracing, arrays) -> FirstHit:
    """The first-hit method called `method` for `surface`. Raises InputError for an unknown name."""
    match method:
        case "paper":
            return Paper(arrays, tracing.step_size, tracing.tolerance, tracing.max_iterations)
        case "exact":
            return cheapest_exact(surface)
        case "interval":
            return IntervalMethod()
    raise InputError(f"unknown method {method!r}; choose one of {', '.join(METHODS)}")


__all__ = ["METHODS", "Crossing", "FirstHit", "LocalRay", "Solid", "choose"]
