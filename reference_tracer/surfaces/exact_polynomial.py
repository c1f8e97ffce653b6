"""Formulas as polynomials with exact rational coefficients (python-flint), and polynomials as formulas."""

from __future__ import annotations

import math
from fractions import Fraction

import numpy as np
from flint import Ordering, fmpq, fmpq_mpoly, fmpq_mpoly_ctx

from .formula import Call, Coordinate, Negation, Node, Number, Power, Product, Sum, children, degree, product, total

HIGHEST_DEGREE = 64
MOST_TERMS = 3000  # of a product written out: all there can be in degree 24
MOST_BITS = 8_000  # of a coefficient, roughly: bits of the largest number times the degree
NEAR_ORIGIN = 2.0**-10  # a centre nearer than this to the origin is left there

_RING = fmpq_mpoly_ctx.get(("x", "y", "z"), Ordering.degrevlex)
_X = _RING.gens()


def polynomial(tree: Node) -> fmpq_mpoly | None:
    """The polynomial that `tree` is, its numbers taken exactly; None where it is none or too large to work with."""
    bound = degree(tree)
    if bound is None or bound > HIGHEST_DEGREE or bound * _most_bits(tree) > MOST_BITS or _most_terms(tree) > MOST_TERMS:
        return None
    return _polynomial(tree)


def _most_terms(tree: Node) -> int:
    """No fewer than the terms of any polynomial on the way to that of `tree`."""
    match tree:
        case Negation(operand):
            return _most_terms(operand)
        case Sum(terms):
            count = sum(_most_terms(term) for _, term in terms)
        case Product(factors):
            count = math.prod(_most_terms(factor) for _, factor in factors)
        case Power(base, n):
            terms = _most_terms(base)
            count = math.comb(terms + n - 1, n)
        case _:
            return 1
    parts = max(map(_most_terms, children(tree)))
    return max(parts, min(count, math.comb(degree(tree) + 3, 3)))


def _most_bits(tree: Node) -> int:
    if isinstance(tree, Number):
        p, q = tree.value.as_integer_ratio()
        return max(p.bit_length(), q.bit_length())
    return max(map(_most_bits, children(tree)), default=0)


def _polynomial(tree: Node) -> fmpq_mpoly:
    match tree:
        case Number(value):
            return _RING.constant(fmpq(*value.as_integer_ratio()))
        case Coordinate(axis):
            return _X[axis]
        case Negation(operand):
            return -_polynomial(operand)
        case Sum(terms):
            return sum((sign * _polynomial(term) for sign, term in terms), _RING.constant(0))
        case Product(factors):
            value = _RING.constant(1)
            for sign, factor in factors:
                value = value * (_polynomial(factor) if sign > 0 else fmpq(1) / fmpq(*factor.value.as_integer_ratio()))
            return value
        case Power(base, n):
            return _polynomial(base) ** n if n else _RING.constant(1)
    raise TypeError(f"no polynomial: {tree}")


def vanishes(tree: Node) -> bool:
    """Whether `tree` is zero wherever it is defined, as far as exact algebra shows it."""
    match tree:
        case Product(factors):
            return any(vanishes(factor) for _, factor in factors)
        case Negation(operand) | Call("sqrt" | "cbrt" | "abs", (operand,)):
            return vanishes(operand)
        case Power(base, n):
            return n > 0 and vanishes(base)
        case Call("min" | "max", arguments):
            return all(map(vanishes, arguments))
    exact = polynomial(tree)
    return exact is not None and exact == 0


def constant_value(tree: Node) -> Fraction | None:
    """The value of a formula that has one everywhere, as far as exact algebra shows it; else None."""
    if vanishes(tree):
        return Fraction(0)
    exact = polynomial(tree)
    return _fraction(exact.leading_coefficient()) if exact is not None and exact.total_degree() == 0 else None


def is_definite(tree: Node) -> bool:
    """Whether `tree` is a polynomial of degree two along every line: its quadratic part is definite (Sylvester)."""
    if degree(tree) != 2 or (p := polynomial(tree)) is None:
        return False
    h = [[_fraction(p.derivative(i).derivative(j).leading_coefficient()) if p.derivative(i).derivative(j) != 0 else 0
          for j in range(3)] for i in range(3)]
    corner = h[0][0] * h[1][1] - h[0][1] ** 2
    determinant = (h[0][0] * (h[1][1] * h[2][2] - h[1][2] ** 2) - h[0][1] * (h[0][1] * h[2][2] - h[1][2] * h[0][2])
                   + h[0][2] * (h[0][1] * h[1][2] - h[1][1] * h[0][2]))
    return corner > 0 and determinant * h[0][0] > 0


def tree_of(p: fmpq_mpoly) -> Node:
    """A formula for p times a positive power of two, its largest coefficient near 1.

    It is written about a centre that removes the terms of second highest degree as far as possible: about the centre of
    a ball, its polynomial has the digits that an expansion about the origin loses far away.
    """
    center = _center(p)
    for axis, c in enumerate(center):
        if c:
            p = p.compose(*(x + fmpq(*c.as_integer_ratio()) if k == axis else x for k, x in enumerate(_X)))
    coefficients = _coefficients(p)
    largest = max(abs(c) for c in coefficients.values())
    scale = Fraction(2) ** (largest.denominator.bit_length() - largest.numerator.bit_length())
    axes = [Coordinate(k) if not c else Sum(((1, Coordinate(k)), (-1 if c > 0 else 1, Number(abs(c)))))
            for k, c in enumerate(center)]
    terms = [(1 if c > 0 else -1, _term(axes, monomial, float(abs(c) * scale)))
             for monomial, c in coefficients.items() if float(abs(c) * scale)]
    terms.sort(key=lambda term: -term[0])  # stable: the first sign of a sum is +
    if terms[0][0] > 0:
        return total(terms)
    return Negation(total([(1, term) for _, term in terms]))


def _term(axes: list[Node], monomial: tuple[int, ...], coefficient: float) -> Node:
    powers = [axis if n == 1 else Power(axis, n) for axis, n in zip(axes, monomial) if n]
    numbers = [Number(coefficient)] if coefficient != 1 or not powers else []
    return product([(1, part) for part in powers + numbers])


def _center(p: fmpq_mpoly) -> list[float]:
    """c, near the least squares solution of c . grad top + next = 0: the parts of highest and second highest degree."""
    n = p.total_degree()
    coefficients = _coefficients(p / p.leading_coefficient())
    try:
        top, following = ({m: float(c) for m, c in coefficients.items() if sum(m) == k} for k in (n, n - 1))
    except OverflowError:  # a coefficient is beyond the largest float times another
        return [0.0] * 3
    if n < 2 or not following:
        return [0.0] * 3
    rows: dict[tuple, int] = {}
    entries = []
    for m, c in top.items():
        for axis in range(3):
            if m[axis]:
                lower = tuple(e - (k == axis) for k, e in enumerate(m))
                entries.append((rows.setdefault(lower, len(rows)), axis, c * m[axis]))
    matrix = np.zeros((len(rows), 3))
    for row, axis, value in entries:
        matrix[row, axis] += value
    right = np.zeros(len(rows))
    for m, c in following.items():
        if m in rows:
            right[rows[m]] = -c
    center = np.linalg.lstsq(matrix, right, rcond=None)[0]
    return [float(c) if abs(c) > NEAR_ORIGIN and math.isfinite(c) else 0.0 for c in center]


def _coefficients(p: fmpq_mpoly) -> dict[tuple[int, ...], Fraction]:
    return {tuple(map(int, monomial)): _fraction(c) for monomial, c in p.to_dict().items()}


def _fraction(c: fmpq) -> Fraction:
    return Fraction(int(c.p), int(c.q))
