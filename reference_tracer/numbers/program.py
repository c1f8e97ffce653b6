"""A function f(x, y, z) as data: instructions, of which one interpreter (interpreter.py) makes f again on any number type.

f is evaluated once, on numbers that write down what is done to them. Registers are used again once nothing needs what they
hold, the coordinates stand in the first three, and the result is left in the first.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from .polynomial import NotAlgebraic

# of polynomials, too
ALGEBRAIC = ("add", "sub", "mul", "square", "negate", "add number", "mul number", "over number", "number")
ELEMENTARY = ("sqrt", "sin", "cos", "tan", "exp", "log", "absolute")
OPERATIONS = (*ALGEBRAIC, "signed mul", "div", "number over", "power", *ELEMENTARY, "minimum", "maximum", "atan2", "of sign",
              "not negative")
LENGTH = 256  # instructions at most
REGISTERS = 32


class Unwritable(Exception):
    """The function does something that is no operation, or is too long."""


@dataclass(frozen=True)
class Program:
    """One instruction an entry: operation, operands and target in a word, and the number that it may need."""

    words: tuple[int, ...] = ()
    numbers: tuple[float, ...] = ()

    @staticmethod
    def of(function: Callable, polynomial: bool = False) -> Program:
        """The program of function(x, y, z); for number types that are only polynomials, powers are products, as theirs are.

        Raises Unwritable.
        """
        writer = _Writer(polynomial)
        writer.write(function)
        if any(operation in ("sqrt", "log") for operation, *_ in writer.steps):
            writer = _Writer(polynomial, signs=True)
            writer.write(function)
        return writer.program()


class _Writer:
    def __init__(self, polynomial: bool, signs: bool = False):
        self.polynomial, self.signs = polynomial, signs  # whether it matters that a number is not negative
        self.steps: list[tuple[str, int, int, float]] = []  # operation, places of its operands, number; place 3 is the first's

    def write(self, function: Callable) -> None:
        value = function(*(Written(self, k) for k in range(3)))
        if not isinstance(value, Written):
            value = self.number(value)
        if value.place != len(self.steps) + 2:  # the result is what was written last
            self.step("add number", value, number=0.0)

    def step(self, operation: str, a: Written, b: Written | None = None, number: float = 0.0) -> Written:
        if operation not in (ALGEBRAIC if self.polynomial else OPERATIONS):
            raise NotAlgebraic(operation)
        if len(self.steps) == LENGTH:
            raise Unwritable(f"more than {LENGTH} instructions")
        self.steps.append((operation, a.place, a.place if b is None else b.place, number))
        return Written(self, len(self.steps) + 2)

    def number(self, value: float) -> Written:
        return self.step("number", Written(self, 0), number=value)

    def program(self) -> Program:
        last = {place: k for k, (_, a, b, _) in enumerate(self.steps) for place in (a, b)}
        free, register = list(range(REGISTERS - 1, 2, -1)), {0: 0, 1: 1, 2: 2}
        free += [place for place in register if place not in last]
        words = []
        for k, (operation, a, b, _) in enumerate(self.steps):
            operands = register[a], register[b]
            free += [register.pop(place) for place in {a, b} if last[place] == k]
            if not free:
                raise Unwritable(f"more than {REGISTERS} registers")
            target = register[k + 3] = 0 if k == len(self.steps) - 1 else free.pop()
            if k + 3 not in last:
                free.append(target)
            words.append(OPERATIONS.index(operation) | operands[0] << 8 | operands[1] << 16 | target << 24)
        return Program(tuple(words), tuple(number for *_, number in self.steps))


@dataclass(frozen=True, slots=True, eq=False)
class Written:
    """A number that is a coordinate or the result of an instruction; what is done to it is written."""

    writer: _Writer
    place: int

    def _with(self, other, operation: str) -> Written:
        return self.writer.step(operation, self, other if isinstance(other, Written) else self.writer.number(other))

    def __neg__(self):
        return self.writer.step("negate", self)

    def __add__(self, other):
        return self._with(other, "add") if isinstance(other, Written) else self.writer.step("add number", self, number=other)

    __radd__ = __add__

    def __sub__(self, other):
        return self._with(other, "sub") if isinstance(other, Written) else self + -other

    def __rsub__(self, other):
        return -self + other

    def __mul__(self, other):
        if other is self:
            return self**2
        if not isinstance(other, Written):
            return self.writer.step("mul number", self, number=other)
        return self._with(other, "signed mul" if self.writer.signs else "mul")

    __rmul__ = __mul__

    def __truediv__(self, other):
        return self._with(other, "div") if isinstance(other, Written) else self.writer.step("over number", self, number=other)

    def __rtruediv__(self, other):
        return self.writer.step("number over", self, number=other)

    def __pow__(self, n: int):
        if n < 0:
            return 1.0 / self**-n
        if n < 3:
            return self.writer.step("square", self) if n == 2 else self if n else self.writer.number(1.0)
        if self.writer.polynomial:
            half = self ** (n // 2)
            return half * half * self if n % 2 else half * half
        return self.writer.step("power", self, number=float(n))

    def of_sign(self, *parts):
        if not self.writer.signs or any(not isinstance(part, Written) for part in parts):
            return self
        if not parts:
            return self.writer.step("not negative", self)
        product = parts[0]
        for part in parts[1:]:
            product = product * part
        return self.writer.step("of sign", self, product)

    def minimum(self, other):
        return self._with(other, "minimum")

    def maximum(self, other):
        return self._with(other, "maximum")

    def atan2(self, x):
        return self._with(x, "atan2")

    def atan2_of(self, y):
        return self.writer.number(y).atan2(self)

    def power_of(self, base):
        return (self.writer.number(base).log() * self).exp()  # as intervals have it

    def _unwritable(self, *_):
        raise Unwritable("a function that jumps, or is rare")

    power = cbrt = floor = heaviside = _unwritable


def _elementary(name: str):
    return lambda self: self.writer.step(name, self)


for _name in ELEMENTARY:
    setattr(Written, _name, _elementary(_name))
