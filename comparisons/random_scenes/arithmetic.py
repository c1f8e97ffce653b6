"""A formula's text as exact numbers, read and evaluated without anything of reference_tracer.

Along a ray f is either a polynomial with rational coefficients (fmpq_poly), about which everything can be known, or
enclosed with its first two derivatives in balls (arb; Johansson 2017, Arb). Numbers in a formula are the doubles that they
are read as.
"""

from __future__ import annotations

import ast
import math
import operator
from collections import Counter
from collections.abc import Callable
from functools import lru_cache

from flint import arb, fmpq, fmpq_poly


class NotPolynomial(ArithmeticError):
    """f is no polynomial of the coordinates."""


class Undefined(ArithmeticError):
    """f has no real value anywhere on the ball it is evaluated on."""


def rational(number) -> fmpq:
    """The rational number that a float, an int, or the middle of an arb is."""
    if isinstance(number, fmpq):
        return number
    if isinstance(number, arb):
        return number.mid().fmpq()
    return fmpq(number) if isinstance(number, int) else fmpq(*float(number).as_integer_ratio())


class Formula:
    """f(x, y, z) as typed, and its odd part: the product of the factors that change the sign of f, each once."""

    def __init__(self, text: str):
        self.tree = ast.parse(text.strip(), mode="eval").body
        self._known: bool | None = None
        self.odd_part = ast.Constant(value=1.0)
        for factor in _odd_factors(self.tree):
            self.odd_part = ast.BinOp(left=self.odd_part, op=ast.Mult(), right=factor)

    @property
    def is_moderate(self) -> bool:
        """Whether the numbers in the formula are such that doubles neither overflow nor underflow."""
        return all(1e-60 < abs(n.value) < 1e60 or n.value == 0 for n in ast.walk(self.tree) if isinstance(n, ast.Constant))

    @property
    def is_polynomial(self) -> bool:
        if self._known is None:
            try:
                self.polynomial(*(fmpq_poly([k, k + 1]) for k in range(3)))
                self._known = True
            except NotPolynomial:
                self._known = False
        return self._known

    def polynomial(self, x: fmpq_poly, y: fmpq_poly, z: fmpq_poly) -> fmpq_poly:
        """f of three polynomials. Raises NotPolynomial."""
        value = _Evaluation(_Polynomials, {"x": x, "y": y, "z": z}).of(self.tree)
        return value if isinstance(value, fmpq_poly) else fmpq_poly([value])

    def taylor(self, point, slope, odd_part: bool = False) -> Taylor:
        """f, or its odd part, at balls for three coordinates with slopes, to flint's precision (ctx.prec). Raises Undefined
        where it certainly has no value."""
        variables = {name: Taylor(p, s, arb(0)) for name, p, s in zip("xyz", point, slope)}
        return Taylor.lift(_Evaluation(_Taylors, variables).of(self.odd_part if odd_part else self.tree))


def _odd_factors(node) -> list:
    """The factors of odd multiplicity in a product of powers."""
    match node:
        case ast.BinOp(op=ast.Mult(), left=a, right=b):
            factors = [*_odd_factors(a), *_odd_factors(b)]
        case ast.BinOp(op=ast.Div(), left=a, right=ast.Constant() as b):
            factors = [*_odd_factors(a), b]
        case ast.BinOp(op=ast.Pow(), left=base, right=ast.Constant(value=n)) if n == int(n) and n > 0:
            factors = _odd_factors(base) if n % 2 else []
        case ast.UnaryOp(op=ast.USub(), operand=a):
            factors = [ast.Constant(value=-1.0), *_odd_factors(a)]
        case _:
            factors = [node]
    times = Counter(ast.dump(factor) for factor in factors)
    once = {ast.dump(factor): factor for factor in factors}
    return [factor for text, factor in once.items() if times[text] % 2]


class _Evaluation:
    """The tree of one formula with the operations of one kind of numbers; constants stay rational."""

    def __init__(self, numbers, variables: dict):
        self.numbers, self.variables = numbers, variables

    def of(self, node):
        return _compiled(node)(self)


@lru_cache(maxsize=1 << 14)
def _compiled(node) -> Callable[[_Evaluation], object]:
    """What an evaluation does at `node`: looked up once, for the same formula is evaluated many thousand times."""
    match node:
        case ast.Constant(value=value):
            constant = rational(float(value))
            return lambda e: constant
        case ast.Name(id="pi"):
            pi = rational(math.pi)
            return lambda e: pi
        case ast.Name(id=name):
            return lambda e: e.variables[name]
        case ast.UnaryOp(op=ast.USub(), operand=a):
            of_a = _compiled(a)
            return lambda e: -of_a(e)
        case ast.UnaryOp(op=ast.UAdd(), operand=a):
            return _compiled(a)
        case ast.BinOp(op=ast.Mult(), left=a, right=b) if ast.dump(a) == ast.dump(b):
            of_a, two = _compiled(a), fmpq(2)
            return lambda e: e.numbers.power(of_a(e), two)  # a square is not negative
        case ast.BinOp(op=op, left=a, right=b):
            of_a, of_b = _compiled(a), _compiled(b)
            match op:
                case ast.Pow():
                    return lambda e: e.numbers.power(of_a(e), of_b(e))
                case ast.Div():
                    return lambda e: e.numbers.divide(of_a(e), of_b(e))
            apply = {ast.Add: operator.add, ast.Sub: operator.sub, ast.Mult: operator.mul}[type(op)]
            return lambda e: apply(of_a(e), of_b(e))
        case ast.Call(func=ast.Name(id=name), args=arguments):
            parts = [_compiled(argument) for argument in arguments]
            return lambda e: getattr(e.numbers, name, _no_polynomial)(*[part(e) for part in parts])
    raise ValueError(f"a formula may not hold {ast.dump(node)}")


class _Polynomials:
    """Functions of polynomials: none but the powers."""

    @staticmethod
    def power(a, n):
        if isinstance(n, fmpq) and n.q == 1 and n >= 0:
            return a ** int(n.p)
        if isinstance(a, fmpq) and isinstance(n, fmpq):
            return rational(float(a) ** float(n)) if n.q != 1 else a ** int(n.p)
        raise NotPolynomial("a power")

    @staticmethod
    def divide(a, b):
        if isinstance(b, fmpq_poly):
            raise NotPolynomial("a division")
        return a * (1 / b)


def _no_polynomial(*arguments):
    raise NotPolynomial("a function")


class Taylor:
    """Balls that hold f, f' and f''/2 for every t of a ball. NaN where nothing is known; a ball about a number near zero
    cannot say that f >= 0, `positive` does."""

    __slots__ = ("value", "slope", "half_curvature", "positive")

    def __init__(self, value: arb, slope: arb, half_curvature: arb, positive: bool = False):
        self.value, self.slope, self.half_curvature = value, slope, half_curvature
        self.positive = positive or bool(value >= 0)

    @classmethod
    def lift(cls, a) -> Taylor:
        return a if isinstance(a, Taylor) else cls(arb(a), arb(0), arb(0), bool(a >= 0))

    def __neg__(self):
        return Taylor(-self.value, -self.slope, -self.half_curvature)

    def __add__(self, other):
        other = Taylor.lift(other)
        return Taylor(self.value + other.value, self.slope + other.slope, self.half_curvature + other.half_curvature,
                      self.positive and other.positive)

    __radd__ = __add__

    def __sub__(self, other):
        return self + -Taylor.lift(other)

    def __rsub__(self, other):
        return Taylor.lift(other) + -self

    def __mul__(self, other):
        if not isinstance(other, Taylor):
            return Taylor(self.value * other, self.slope * other, self.half_curvature * other, self.positive and other >= 0)
        a, b = self, other
        return Taylor(a.value * b.value, a.value * b.slope + a.slope * b.value,
                      a.value * b.half_curvature + a.slope * b.slope + a.half_curvature * b.value, a.positive and b.positive)

    __rmul__ = __mul__

    @property
    def straddles(self) -> bool:
        """Whether f may be zero."""
        return not (self.value > 0 or self.value < 0)

    def through(self, value: arb, first: arb, half_second: arb, positive: bool = False) -> Taylor:
        """A function of f: its value and its derivatives at f."""
        return Taylor(value, first * self.slope, first * self.half_curvature + half_second * self.slope * self.slope,
                      positive)


_NAN = arb.nan()
_NOTHING = Taylor(_NAN, _NAN, _NAN)


class _Taylors:
    """Functions of Taylor series."""

    @staticmethod
    def power(a, n):
        if isinstance(n, Taylor):
            return _Taylors.exp(_Taylors.log(Taylor.lift(a)) * n)
        if not isinstance(a, Taylor):
            return a ** int(n.p) if n.q == 1 else rational(float(a) ** float(n))
        if n.q != 1:
            return _Taylors._real_power(a, n)
        if n < 0:
            return _Taylors.divide(fmpq(1), _Taylors.power(a, -n))
        k, v = int(n.p), a.value
        return a.through(v**k, k * v ** (k - 1) if k else arb(0), k * (k - 1) // 2 * v ** (k - 2) if k > 1 else arb(0),
                         k % 2 == 0 or a.positive)

    @staticmethod
    def _real_power(a: Taylor, n: fmpq) -> Taylor:
        v, p = a.value, arb(n)
        if v > 0:
            value = _raised(v, p)
            return a.through(value, p * value / v, p * (p - 1) / 2 * value / (v * v), True)
        if v < 0:
            raise Undefined("a power of a negative number")
        if not a.positive or n < 0 or not v.is_finite():
            return _NOTHING
        up_to = lambda q: arb(0).union(_raised(v.upper(), q)) if q > 0 else _NAN
        return a.through(up_to(p), p * up_to(p - 1), p * (p - 1) / 2 * up_to(p - 2), True)

    @staticmethod
    def divide(a, b):
        if not isinstance(b, Taylor):
            return a * (1 / b)
        if b.straddles:
            return _NOTHING
        v = 1 / b.value
        return Taylor.lift(a) * b.through(v, -v * v, v * v * v, b.positive)

    @staticmethod
    def sqrt(a):
        return _Taylors._real_power(Taylor.lift(a), fmpq(1, 2))

    @staticmethod
    def cbrt(a):
        a = Taylor.lift(a)
        v = a.value
        if v > 0:
            return _Taylors._real_power(a, fmpq(1, 3))
        if v < 0:
            return -_Taylors.cbrt(-a)
        if not v.is_finite():
            return _NOTHING
        root = lambda c: c.root(3) if c > 0 else -((-c).root(3)) if c < 0 else arb(0)
        low = arb(0) if a.positive else root(v.lower())
        return Taylor(low.union(root(v.upper())), _NAN, _NAN, a.positive)

    @staticmethod
    def log(a):
        a = Taylor.lift(a)
        v = a.value
        if v < 0:
            raise Undefined("the logarithm of a negative number")
        return a.through(v.log(), 1 / v, -1 / (2 * v * v)) if v > 0 else _NOTHING

    @staticmethod
    def exp(a):
        a = Taylor.lift(a)
        v = a.value.exp()
        return a.through(v, v, v / 2, True)

    @staticmethod
    def sin(a):
        a = Taylor.lift(a)
        sin, cos = a.value.sin_cos()
        return a.through(sin, cos, -sin / 2)

    @staticmethod
    def cos(a):
        a = Taylor.lift(a)
        sin, cos = a.value.sin_cos()
        return a.through(cos, -sin, -cos / 2)

    @staticmethod
    def tan(a):
        return _Taylors.divide(_Taylors.sin(a), _Taylors.cos(a))

    @staticmethod
    def abs(a):
        a = Taylor.lift(a)
        if a.positive:
            return a
        larger = _Taylors.max(a, -a)
        return Taylor(larger.value, larger.slope, larger.half_curvature, True)

    @staticmethod
    def max(a, b):
        a, b = Taylor.lift(a), Taylor.lift(b)
        if a.value >= b.value:
            return a
        if b.value >= a.value:
            return b
        # the larger of the two: at a kink the slope lies between both
        return Taylor(a.value.max(b.value), a.slope.union(b.slope), _NAN, a.positive or b.positive)

    @staticmethod
    def min(a, b):
        return -_Taylors.max(-Taylor.lift(a), -Taylor.lift(b))


def _raised(v: arb, p: arb) -> arb:
    return (v.log() * p).exp() if v > 0 else arb(0)
