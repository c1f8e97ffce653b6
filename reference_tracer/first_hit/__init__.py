"""First-hit methods: given f, rays, a range and the side each ray is on, where does it first change side?

One file a method, all on the interface of `interface.py`; `choose` maps a method's name to the method for a surface.
"""

from __future__ import annotations

from ..errors import InputError
from .descartes import Descartes
from .exact import cheapest_exact
from .interface import FirstHit, Intersection, LocalRay, Solid
from .interval import IntervalMethod
from .paper import Paper
from .proof import Proof

METHODS = {
    "paper": "the document's own: fixed steps, then free Newton; includes its failures",
    "exact": "misses nothing: closed forms, Descartes' rule, interval arithmetic, the cheapest that is safe",
    "descartes": "Descartes' rule of signs, for algebraic surfaces; interval arithmetic for the others",
    "interval": "interval arithmetic for every surface",
    "proof": "interval arithmetic, outward rounded: its answers are proofs",
}


def choose(method: str, obj, tracing, arrays) -> FirstHit:
    """The first-hit method for the object `obj`: its own, else the one called `method`.

    Raises InputError for an unknown name.
    """
    surface, own = obj.surface, obj.first_hit
    match own.method if own else method:
        case "paper":
            step_size = (own and own.step_size) or tracing.step_size
            return Paper(arrays, step_size, tracing.tolerance, tracing.max_iterations)
        case "exact":
            if surface.drowns and arrays.precision == 64:  # the others take signs from floats
                return Proof()
            return cheapest_exact(surface.degree, surface.bounded_quadric)
        case "descartes":
            return Descartes() if surface.degree is not None else IntervalMethod()
        case "proof":
            if arrays.precision != 64:
                raise InputError("the method proof rounds outwards in double precision; use --precision 64")
            return Proof()
        case "interval":
            return IntervalMethod()
    raise InputError(f"unknown method {method!r}; choose one of {', '.join(METHODS)}")


__all__ = ["METHODS", "Intersection", "FirstHit", "LocalRay", "Solid", "choose"]
