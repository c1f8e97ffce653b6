"""Real roots of polynomials with rational coefficients, isolated and counted exactly."""

from __future__ import annotations

import itertools
from dataclasses import dataclass

from flint import arb, ctx, fmpq, fmpq_poly, fmpz_poly

PRECISIONS = (96, 192, 384, 768, 1536, 3072, 6144, 12288)  # bits, tried in turn
ROOMS = 2.0**-20  # distance from the real axis, relative to the root, below which a pair of roots is a near miss


@dataclass(frozen=True)
class Root:
    """A real root: a ball that holds it and no other, and its multiplicity."""

    t: arb
    multiplicity: int

    @property
    def crosses(self) -> bool:
        """A polynomial changes sign at a root of odd multiplicity and touches zero at one of even (decision M1)."""
        return self.multiplicity % 2 == 1


def positive_roots(p: fmpq_poly, limit: fmpq, bits: int = 96) -> list[Root]:
    """The distinct roots of p != 0 in (0, limit], ascending; balls of about `bits` correct bits.

    Squarefree factors separate roots by multiplicity; FLINT isolates the roots of each (Johansson, arb_fmpz_poly). A
    root at 0 or at `limit` is divided out first, so that every remaining comparison is decided at some precision.
    """
    p, _ = _without_root(p, fmpq(0))
    p, at_limit = _without_root(p, limit)
    factors = p.numer().factor_squarefree()[1] if p.degree() > 0 else []
    for precision in (bits, *(b for b in PRECISIONS if b > bits)):
        with ctx.workprec(precision):
            roots = _sorted([Root(t, m) for factor, m in factors for t in _real_roots(factor)])
            if roots is None:
                continue
            inside = [_between(r.t, limit) for r in roots]
            if None not in inside:
                found = [r for r, kept in zip(roots, inside) if kept]
                return found + ([Root(arb(limit), at_limit)] if at_limit else [])
    raise ArithmeticError("two roots could not be told apart with 12288 bits")


def near_misses(p: fmpq_poly, limit: fmpq) -> list[arb]:
    """Where |p| nearly touches zero in (0, limit) without reaching it: real parts of root pairs close to the axis."""
    z = p.numer()
    with ctx.workprec(PRECISIONS[1]):
        pairs = [r for r, _ in (z.complex_roots() if z.degree() > 1 else []) if r.imag > 0]
        return [r.real for r in pairs if r.real > 0 and r.real < limit and r.imag < ROOMS * (1 + abs(r.real))]


def _without_root(p: fmpq_poly, t: fmpq) -> tuple[fmpq_poly, int]:
    """p without its root t, and that root's multiplicity."""
    multiplicity, factor = 0, fmpq_poly([-t, 1])
    while p.degree() > 0 and p(t) == 0:
        p, multiplicity = p // factor, multiplicity + 1
    return p, multiplicity


def _real_roots(p: fmpz_poly) -> list[arb]:
    """The real roots of a squarefree p at the working precision."""
    if p.degree() == 1:
        return [arb(fmpq(-p[0], p[1]))]
    if p.degree() == 2:
        c, b, a = (p[k] for k in range(3))
        discriminant = b * b - 4 * a * c
        if discriminant <= 0:  # squarefree: never zero
            return []
        root = arb(discriminant).sqrt()
        q = -(b + root) / 2 if b >= 0 else (root - b) / 2  # no cancellation
        return [q / a, c / q] if b != 0 else [root / (2 * a), -root / (2 * a)]
    return [t.real for t, _ in p.complex_roots() if t.imag == 0]


def _sorted(roots: list[Root]) -> list[Root] | None:
    """Ascending; None where two balls overlap."""
    roots = sorted(roots, key=lambda r: r.t.mid().fmpq())
    return roots if all(a.t < b.t for a, b in itertools.pairwise(roots)) else None


def _between(t: arb, limit: fmpq) -> bool | None:
    """Whether 0 < t < limit; None where the ball does not tell."""
    if t < 0 or t > limit:
        return False
    return True if t > 0 and t < limit else None
