"""The form of a formula that exact methods trace: the same solid, but regular roots and values of a sane size.

f = c q1^m1 q2^m2 ... changes sign where a factor of odd multiplicity does, and there only: an even one touches zero, which
is no crossing (decision M1). So f and sign(c) times the product of the odd q_i, once each, bound one solid; the gradient of
the second does not vanish where f is multiple. A positive factor of scale changes nothing either.

Factors that the formula writes are taken from it as they are, whatever is within them: that keeps the digits of the user's
own form. Factors hidden in an expanded polynomial come from its square-free factorisation (python-flint). A factor is
dropped only if it is defined everywhere, so that f and its form are undefined at the same points (decision M7), and if its
zeros fill no volume: where max(x, 0)^2 is zero, outside it is (O1).
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass, field

from flint import fmpq_mpoly

from .exact_polynomial import polynomial, tree_of, vanishes
from .formula import (
    Call,
    Coordinate,
    Negation,
    Node,
    Number,
    Power,
    Product,
    RealPower,
    Sum,
    children,
    degree,
    has_coordinates,
    negation,
    product,
    rebuilt,
    sign_parts,
    total,
)

LARGEST_SCALE = 64  # |log2| of the size of values beyond which scale is taken out: squares of gradients stay finite
MOST_TERMS = 500  # of an expanded form; longer ones cost more than they save


def odd_part(tree: Node) -> Node:
    """`tree` itself if nothing is to be gained, else a formula with the sign of `tree` wherever that is defined, except
    where a factor of even multiplicity vanishes: there `tree` is zero and this is not."""
    if not has_coordinates(tree) or vanishes(tree):
        return tree
    factors = _Factors()
    factors.take(tree, 1)
    factors.make_square_free()
    if not factors.changed and abs(magnitude(tree)) <= LARGEST_SCALE:
        return tree
    return factors.form()


@dataclass
class _Factors:
    """A formula as sign times product of powers."""

    sign: int = 1
    multiplicity: dict[Node, int] = field(default_factory=dict)
    changed: bool = False  # more than its sign and its positive factors was taken off

    def take(self, tree: Node, m: int) -> None:
        """Multiplies by tree**m."""
        match tree:
            case Number(value):  # not zero: see odd_part
                self.sign *= 1 if value > 0 or m % 2 == 0 else -1
            case Negation(operand):
                self.sign *= (-1) ** m
                self.take(operand, m)
            case Product(factors):
                for sign, factor in factors:
                    if sign > 0 or isinstance(factor, Number):
                        self.take(factor, m)
                    elif not (is_positive(factor) and is_defined(factor)):
                        self._add(Product(((1, Number(1.0)), (-1, factor))), m)
            case Power(base, n) if n > 0:
                self.changed |= n > 1
                self.take(base, m * n)
            case Call("cbrt", (operand,)):
                self.changed = True  # the sign of its operand, whose roots are regular
                self.take(operand, m)
            case Call("abs", (operand,)):
                self.changed = True
                self.take(operand, 2 * m)
            case Call("min" | "max", _):
                form = rebuilt(tree, odd_part)  # of signs, too, it is the least or the largest
                self.changed |= form != tree
                self._add(form, m)
            case _:
                self._add(tree, m)

    def _add(self, tree: Node, m: int) -> None:
        if is_defined(tree) and is_positive(tree):
            return
        if is_nonnegative(tree):
            self.changed |= is_defined(tree)
            m *= 2
        self.changed |= tree in self.multiplicity
        self.multiplicity[tree] = self.multiplicity.get(tree, 0) + m

    def make_square_free(self) -> None:
        """Replaces polynomial factors of odd multiplicity that are not square-free together by expanded ones that are,
        and those whose highest terms cancel by what is left of them."""
        odd = {tree: p for tree, m in self.multiplicity.items()
               if m % 2 and (p := polynomial(tree)) is not None and len(p) <= MOST_TERMS}
        for tree, p in list(odd.items()):
            if not _is_square_free(p) or p.total_degree() < degree(tree):
                del odd[tree]
                odd |= self._replaced([tree], p)
        whole = math.prod(odd.values(), start=_ONE)
        if len(odd) > 1 and not _is_square_free(whole):
            self._replaced(list(odd), whole)

    def _replaced(self, trees: list[Node], p: fmpq_mpoly) -> dict[Node, fmpq_mpoly]:
        """Puts the odd part of p, their product, in the place of `trees`; returns its factors."""
        constant, factors = p.factor_squarefree()
        kept = {tree_of(q): q for q, m in factors if m % 2 and q.total_degree() > 0}
        if p == 0 or sum(len(q) for q in kept.values()) > MOST_TERMS:
            return {}
        for tree in trees:
            del self.multiplicity[tree]
        self.changed = True
        self.sign *= 1 if constant > 0 else -1
        self.multiplicity |= dict.fromkeys(kept, 1)
        return kept

    def form(self) -> Node:
        parts = [_of_sane_size(tree if m % 2 or is_nonnegative(tree) else Power(tree, 2))
                 for tree, m in self.multiplicity.items()
                 if m % 2 or not (is_defined(tree) and zeros_are_thin(tree))]
        if not parts:  # f has one sign: a solid without surface
            return total([(1, product([(1, Coordinate(0)), (1, Number(0.0))])), (1, Number(float(self.sign)))])
        form = product([(1, part) for part in parts])
        return form if self.sign > 0 else negation(form)


_ONE = polynomial(Number(1.0))


def _is_square_free(p: fmpq_mpoly) -> bool:
    return all(m == 1 for _, m in p.factor_squarefree()[1])


# --- what is known of a formula's values -------------------------------------------------------------------------------
def is_defined(tree: Node) -> bool:
    """Whether `tree` has a finite value everywhere, rounding and range apart; False where that is not seen."""
    if not all(map(is_defined, children(tree))):
        return False
    match tree:
        case Product(factors):
            return all(sign > 0 or is_positive(factor) or isinstance(factor, Number) for sign, factor in factors)
        case Power(base, n):
            return n >= 0 or is_positive(base)
        case RealPower(base, Number(p)):
            return is_positive(base) or (p > 0 and is_nonnegative(base))
        case RealPower(base):
            return is_positive(base)
        case Call("sqrt", (operand,)):
            return is_nonnegative(operand)
        case Call("log", (operand,)):
            return is_positive(operand)
        case Call("tan" | "asin" | "acos"):
            return False
        case Call("mod", (_, divisor)) | Call("smin" | "smax", (_, _, divisor)):
            return isinstance(divisor, Number) and divisor.value != 0
        case Call("smoothstep", (start, stop, _)):
            return isinstance(start, Number) and isinstance(stop, Number) and start != stop
    return True


def is_positive(tree: Node) -> bool:
    """Whether `tree` is above zero wherever it is defined; False where that is not seen."""
    match tree:
        case Number(value):
            return value > 0
        case Sum(terms):
            return all(_adds(sign, term, is_nonnegative) for sign, term in terms) and any(
                _adds(sign, term, is_positive) for sign, term in terms)
        case Product(factors):
            return all(is_positive(factor) for _, factor in factors)
        case Power(base, n):
            return is_positive(base) or n == 0
        case RealPower(base):
            return is_positive(base)
        case Call("exp" | "cosh"):
            return True
        case Call("sqrt" | "cbrt" | "abs" | "min", arguments):
            return all(map(is_positive, arguments))
        case Call("max", arguments):
            return any(map(is_positive, arguments))
    return False


def is_nonnegative(tree: Node) -> bool:
    """Whether `tree` is not below zero wherever it is defined; False where that is not seen."""
    match tree:
        case Number(value):
            return value >= 0
        case Sum(terms):
            return all(_adds(sign, term, is_nonnegative) for sign, term in terms)
        case Product():
            return all(map(is_nonnegative, sign_parts(tree)))
        case Power(base, n):
            return n % 2 == 0 or is_nonnegative(base)
        case RealPower():
            return True
        case Call("exp" | "abs" | "sqrt" | "cosh" | "heaviside" | "fract" | "smoothstep" | "acos"):
            return True
        case Call("cbrt" | "min", arguments):
            return all(map(is_nonnegative, arguments))
        case Call("max", arguments):
            return any(map(is_nonnegative, arguments))
    return False


def _adds(sign: int, term: Node, holds) -> bool:
    return holds(term) if sign > 0 else isinstance(term, Number) and holds(Number(-term.value))


MOST_BRANCHES = 64
ANALYTIC = {"sin", "cos", "tan", "exp", "log", "cbrt", "sinh", "cosh", "tanh", "atan", "asin", "acos"}


def zeros_are_thin(tree: Node) -> bool:
    """Whether `tree` is zero on no open set, by its structure; False where that is not seen.

    An analytic function that is zero on an open set is zero. |a| is a or -a, the least and the largest is one of two: if
    no choice of branches vanishes, none of their zeros has a volume. (A cube root is analytic in itself, a square root of
    a square-free polynomial >= 0 but for a set that parts no space.)
    """
    match tree:
        case Negation(operand) | Power(operand) | RealPower(operand) | Call("sqrt" | "cbrt" | "abs", (operand,)):
            return zeros_are_thin(operand)
        case Product(factors):
            return all(zeros_are_thin(factor) for sign, factor in factors if sign > 0)
    branches = _branches(tree)
    return branches is not None and not any(map(vanishes, branches))


def _branches(tree: Node) -> list[Node] | None:
    """Analytic functions of which `tree` is one at every point; None where they are too many, or not seen to be analytic."""
    match tree:
        case Call("abs", (operand,)):
            inner = _branches(operand)
            return inner and [*inner, *map(negation, inner)]
        case Call("min" | "max", (a, b)):
            first, second = _branches(a), _branches(b)
            return first and second and [*first, *second]
        case Call("sqrt", (operand,)) | RealPower(operand, Number()) if not is_positive(operand):
            p = polynomial(operand)
            if p is None or not is_nonnegative(operand) or not _is_square_free(p):
                return None
        case Call(name) if name not in ANALYTIC and name != "sqrt":
            return None
    choices = [_branches(child) for child in children(tree)]
    if None in choices or math.prod(map(len, choices)) > MOST_BRANCHES:
        return None
    return [rebuilt(tree, lambda _, rest=rest: next(rest)) for rest in map(iter, itertools.product(*choices))]


# --- scale -------------------------------------------------------------------------------------------------------------
def magnitude(tree: Node) -> float:
    """About log2 of the largest terms where x, y, z are about 1."""
    match tree:
        case Number(value):
            return math.log2(abs(value)) if value else -math.inf
        case Negation(operand) | Call("abs", (operand,)):
            return magnitude(operand)
        case Sum(terms):
            return max(magnitude(term) for _, term in terms)
        case Product(factors):
            return sum(sign * _finite(magnitude(factor)) for sign, factor in factors)
        case Power(base, n):
            return n * _finite(magnitude(base))
        case RealPower(base, Number(p)):
            return p * _finite(magnitude(base))
        case Call("sqrt", (operand,)):
            return magnitude(operand) / 2
        case Call("cbrt", (operand,)):
            return magnitude(operand) / 3
        case Call("min" | "max", arguments):
            return min(map(magnitude, arguments), key=abs)
    return 0.0


def _finite(size: float) -> float:
    return size if math.isfinite(size) else 0.0


class _OutOfRange(ArithmeticError):
    """A number would not stay a normal double."""


def _of_sane_size(tree: Node) -> Node:
    size = magnitude(tree)
    if abs(size) <= LARGEST_SCALE or math.isinf(size):
        return tree
    try:
        return scaled(tree, -round(size))
    except _OutOfRange:  # its numbers are too far apart for any scale
        return tree


def scaled(tree: Node, k: int) -> Node:
    """`tree` times 2**k, the factor taken into its numbers, so that nothing within it leaves the range of doubles.

    Raises _OutOfRange where a number would.
    """
    match tree:
        case Number(value):
            if not _fits(value, k):
                raise _OutOfRange
            return Number(math.ldexp(value, k))
        case Negation(operand):
            return Negation(scaled(operand, k))
        case Sum(terms):
            return Sum(tuple((sign, scaled(term, k)) for sign, term in terms))
        case Product(factors):
            for j, (sign, factor) in enumerate(factors):
                if isinstance(factor, Number) and _fits(factor.value, sign * k):
                    return Product((*factors[:j], (sign, scaled(factor, sign * k)), *factors[j + 1:]))
            for j, (sign, factor) in enumerate(factors):
                if sign > 0 and isinstance(factor, (Sum, Power)):
                    return Product((*factors[:j], (1, scaled(factor, k)), *factors[j + 1:]))
        case Power(base, n) if n > 0 and not isinstance(base, Coordinate):
            whole, rest = divmod(k, n)
            power = Power(scaled(base, whole), n)
            return Product(((1, power), (1, Number(2.0**rest)))) if rest else power
        case Call("abs" | "min" | "max"):
            return rebuilt(tree, lambda argument: scaled(argument, k))
        case Call("sqrt", (operand,)):
            return Call("sqrt", (scaled(operand, 2 * k),))
        case Call("cbrt", (operand,)):
            return Call("cbrt", (scaled(operand, 3 * k),))
    return Product(((1, tree), (1, scaled(Number(1.0), k))))


def _fits(value: float, k: int) -> bool:
    """Whether value 2**k is a normal double."""
    return value == 0 or -1021 <= math.frexp(value)[1] + k <= 1024
