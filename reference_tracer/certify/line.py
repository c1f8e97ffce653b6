"""What one exact ray does with one object: the changes of side along it, decided by python-flint.

The ray o + t d in the object's own frame has rational numbers for o and d; floats are such numbers. It is known to be
on side `inside` at t = 0 (decision M2). Its crossings on (0, limit] follow from the signs of g(t) = f(o + t d):

- A root of even multiplicity touches and is no crossing (M1).
- If g just after 0 has the sign of the known side, every odd root ahead is a crossing.
- If it has the other sign, the ray starts on the surface, and rounding has put its origin on the far side of it. Where
  g heads back to zero, the root ahead is the surface the ray starts on: the ray has crossed nothing there (M3); if it
  never gets there, on which side it is stays open. Where g heads away from zero, the ray leaves its side as it starts,
  which is a crossing at t = 0: that happens where two surfaces coincide, one of them just passed.
"""

from __future__ import annotations

from dataclasses import dataclass, field

from flint import arb

from ..numbers.exact import RationalPolynomial, rational
from ..surfaces.surface import Surface
from .roots import positive_roots
from .search import NEVER_BACK, Undecidable, search


@dataclass
class Line:
    """The crossings of a ray with one object, ascending, as balls; or why they cannot be told."""

    crossings: list[arb] = field(default_factory=list)
    touches: list[arb] = field(default_factory=list)  # even roots: no crossings (M1)
    multiple: list[arb] = field(default_factory=list)  # crossings at a root of multiplicity 3 or more
    undecided: str = ""  # the reason, empty where everything is decided
    wrong_start: bool = False  # just after 0 the ray is not on the side it is known to be on

    @property
    def first(self) -> arb | None:
        return self.crossings[0] if self.crossings else None


def ray_polynomial(surface: Surface, o, d) -> RationalPolynomial:
    """g(t) of an algebraic surface, signed so that g < 0 is inside."""
    parameters = {name: RationalPolynomial.constant(value) for name, value in surface.parameters.items()}
    g = surface.exact_form(*RationalPolynomial.along(o, d), **parameters)
    return -g if surface.inside == "positive" else g


def follow(surface: Surface, o, d, inside: bool, limit, bits: int = 96, only_first: bool = False) -> Line:
    """The line of a ray in the surface's own frame; `o`, `d` are three numbers each that `rational` accepts.

    Algebraic surfaces are decided exactly. Others are enclosed to `bits` bits (search.py); `only_first` spares the
    rest of the ray there.
    """
    if surface.exact_form is None:
        try:
            crossings, wrong_start = search(surface, o, d, inside, limit, bits, only_first)
        except Undecidable as reason:
            return Line(undecided=str(reason), wrong_start=str(reason) == NEVER_BACK)
        return Line(crossings, wrong_start=wrong_start)
    g = ray_polynomial(surface, o, d).p
    if g == 0:
        return Line(undecided="the ray lies within the surface")
    roots = positive_roots(g, rational(limit), bits)
    crossings = [r.t for r in roots if r.crosses]
    line = Line(touches=[r.t for r in roots if not r.crosses],
                multiple=[r.t for r in roots if r.crosses and r.multiplicity > 1])
    line.wrong_start = starts_inside(g) != inside
    if line.wrong_start:
        if g[0] * g[1] >= 0:
            crossings = [arb(0), *crossings]
        elif not crossings:
            return Line(undecided=NEVER_BACK, wrong_start=True)
        else:
            crossings = crossings[1:]
    line.crossings = crossings
    return line


def starts_inside(g) -> bool:
    """The side just after t = 0: the sign of the lowest coefficient that is not zero."""
    return next(c for c in g.coeffs() if c != 0) < 0

