"""Carries out programs (program.py) on number types made of Dr.Jit arrays: one kernel for all formulas.

An instruction does with the numbers of the registers what the number type itself does, so that what is proven of f by its
enclosures is proven of the program. All rays carry out the same instruction at a time.
"""

from __future__ import annotations

import operator
from collections.abc import Callable
from dataclasses import dataclass, make_dataclass
from functools import cache

import drjit as dr

from . import functions as fn
from .dual import Dual
from .interval import Interval
from .polynomial import OfDegree, Polynomial
from .program import ALGEBRAIC, ELEMENTARY, LENGTH, OPERATIONS, REGISTERS, Program


def whole_power(a, n):
    """a**n for n > 1 that is known when a kernel runs (UInt), with the roundings of a**n."""
    match a:
        case Dual():
            return a._chain(whole_power(a.value, n), whole_power(a.value, n - 1) * type(_bound(a))(n))
        case Interval():
            at_low, at_high, odd = whole_power(a.low, n), whole_power(a.high, n), (n & 1) == 1
            straddles = (a.low <= 0) & (a.high >= 0)
            found = a.rounded(dr.select(odd, at_low, dr.select(straddles, 0.0, fn.minimum(at_low, at_high))),
                              dr.select(odd, at_high, fn.maximum(at_low, at_high)), type(at_low)(n))
            return type(a)(dr.select(~odd & (found.low < 0), 0.0, found.low), found.high, ~odd | a.nonnegative)
    return dr.while_loop((n, a, type(a)(1)), lambda n, square, power: n > 0, lambda n, square, power: (
        n >> 1, square * square, dr.select((n & 1) == 1, power * square, power)))[2]


def _bound(a):
    """An array among the numbers of `a`."""
    while isinstance(a, Dual):
        a = a.value
    return a.low if isinstance(a, Interval) else a


def _of_one(function: Callable) -> Callable:
    return lambda a, b, number: function(a)


def _of_two(function: Callable) -> Callable:
    return lambda a, b, number: function(a, b)


_MEANINGS = {  # of the operands and of the number that the instruction holds
    "add": _of_two(operator.add), "sub": _of_two(operator.sub), "mul": _of_two(operator.mul),
    "signed mul": lambda a, b, number: fn.of_sign(a * b, a, b), "square": lambda a, b, number: a**2,
    "negate": _of_one(operator.neg), "number": lambda a, b, number: number,
    "add number": lambda a, b, number: a + number, "mul number": lambda a, b, number: a * number,
    "over number": lambda a, b, number: fn.quotient(a, number), "div": _of_two(fn.quotient),
    "number over": lambda a, b, number: fn.quotient(number, a),
    "power": lambda a, b, number: whole_power(a, dr.uint32_array_t(type(number))(number)),
    **{name: _of_one(getattr(fn, name)) for name in ELEMENTARY},
    **{name: _of_two(getattr(fn, name)) for name in ("minimum", "maximum", "atan2")},
    "of sign": _of_two(fn.of_sign), "not negative": _of_one(fn.of_sign)}
MEANINGS = [_MEANINGS[name] for name in OPERATIONS]


@dataclass(frozen=True)
class Shape:
    """How a number is kept in a register: as the arrays `parts` makes of it, of which `number` makes it again."""

    derivatives: int | None  # of a dual; None of what is none
    interval: type[Interval] | None
    degree: int | None = None  # of a polynomial

    @staticmethod
    def of(number, degree: int) -> Shape:
        if isinstance(number, Polynomial):
            return Shape(None, None, degree)
        value = number.value if isinstance(number, Dual) else number
        return Shape(len(number.derivatives) if isinstance(number, Dual) else None,
                     type(value) if isinstance(value, Interval) else None)

    def parts(self, number, Float) -> list:
        if self.degree is not None:
            c = number.c[:self.degree + 1] if isinstance(number, Polynomial) else (number,)
            return [*map(Float, c), *(Float(0) for _ in range(self.degree + 1 - len(c)))]
        if self.derivatives is None:
            return self._value_parts(number, Float)
        number = number if isinstance(number, Dual) else Dual(number, (None,) * self.derivatives)
        slopes = [part for d in number.derivatives for part in self._bounds(0.0 if d is None else d, Float)]
        return self._value_parts(number.value, Float) + slopes

    def _bounds(self, value, Float) -> list:
        if self.interval is None:
            return [Float(value)]
        value = self.interval.of(value)
        return [Float(value.low), Float(value.high)]

    def _value_parts(self, value, Float) -> list:
        bounds = self._bounds(value, Float)
        if self.interval is not None:  # Dr.Jit 1.5 makes invalid code of Bool arrays in local memory
            bounds.append(dr.select(dr.mask_t(Float)(self.interval.of(value).nonnegative), Float(1), Float(0)))
        return bounds

    def number(self, parts: list):
        if self.degree is not None:
            return Polynomial(tuple(parts))
        size = 1 if self.interval is None else 2
        make = (lambda bounds: bounds[0]) if self.interval is None else (lambda bounds: self.interval(*bounds))
        first = 1 if self.interval is None else 3
        value = parts[0] if self.interval is None else self.interval(parts[0], parts[1], parts[2] > 0)
        if self.derivatives is None:
            return value
        return Dual(value, tuple(make(parts[k:k + size]) for k in range(first, len(parts), size)))


@cache
def _register(Float, count: int) -> type:
    return make_dataclass("Register", [(f"part_{k}", Float) for k in range(count)])


class Interpreter:
    """The function of a program, on any of our number types of Dr.Jit arrays; of polynomials, whose
    degree is `degree`, those up to `highest`.

    A program without instructions is of a function that is not known, whose every value is NaN.
    """

    def __init__(self, program: Program, arrays, highest: int = 0, degree: int = 0):
        self.Float, self.UInt, self.highest, self.degree = arrays.Float, arrays.UInt, highest, arrays.count(degree)
        rest = LENGTH - len(program.words)  # kernels are recorded for arrays of one length
        self.words, self.numbers = arrays.UInt([*program.words] + [0] * rest), arrays.Float([*program.numbers] + [0.0] * rest)
        self.count = arrays.count(len(program.words))
        dr.make_opaque(self.words, self.numbers)

    @property
    def variables(self) -> list:
        return [self.words, self.numbers, self.count, self.degree]

    def __call__(self, *point):
        shape = Shape.of(point[0], self.highest)
        if shape.derivatives == 3:  # one derivative at a time: as those along a ray, which kernels have at hand
            alone = [self(*(Dual(p.value, (p.derivatives[k],)) for p in point)) for k in range(3)]
            return Dual(alone[0].value, tuple(part.derivative() for part in alone))
        Float, UInt = self.Float, self.UInt
        coordinates = [shape.parts(number, Float) for number in point]
        # calls: an operation stands in a kernel once for each number type, however often f is evaluated
        calls = [lambda a, b, c, f=f: shape.parts(f(shape.number(a), shape.number(b), c), Float)
                 for f in MEANINGS[:len(ALGEBRAIC) if shape.degree is not None else None]]
        Register = _register(Float, len(coordinates[0]))
        registers = dr.alloc_local(Register, REGISTERS)
        for k, parts in enumerate(coordinates):
            registers[k] = Register(*parts)

        def carry_out(step, registers):
            word = dr.gather(UInt, self.words, step)
            read = lambda place: list(vars(registers[place & 0xff]).values())
            registers[word >> 24] = Register(*dr.switch(word & 0xff, calls, read(word >> 8), read(word >> 16),
                                                        dr.gather(Float, self.numbers, step)))
            return step + 1, registers

        _, registers = dr.while_loop((UInt(0), registers), lambda step, _: step < self.count, carry_out)
        value = shape.number([dr.select(self.count > 0, part, dr.nan) for part in vars(registers[0]).values()])
        return value if shape.degree is None else OfDegree(value.c, self.degree)
