"""A number type that writes instead of computing: f(x, y, z) evaluated on it is the text of an SDL function.

So a surface's one function is also what POV-Ray's isosurfaces are made of, user expressions included. Every operand is
written once: the text is as long as the formula, whatever its nesting.
"""

from __future__ import annotations

from dataclasses import dataclass

from raytruth.reference_tracer.numbers import composed

from .words import number

PRODUCT = 4  # up to this power a coordinate is multiplied out, several times as fast as pow

# pow knows no negative base with a fractional exponent
CBRT = "#declare Cbrt = function(u) { select(u, -1, 0, 1) * pow(abs(u), 1/3) };"


@dataclass(frozen=True)
class Text:
    """`code` is an SDL float expression that needs no brackets around it."""

    code: str
    is_coordinate: bool = False

    @staticmethod
    def coordinates() -> tuple[Text, Text, Text]:
        return tuple(Text(name, is_coordinate=True) for name in "xyz")

    @staticmethod
    def of(value) -> Text:
        if isinstance(value, Text):
            return value
        code = number(value)
        return Text(f"({code})" if code.startswith("-") else code)

    # --- ring ------------------------------------------------------------------------------------------------------
    def _joined(self, sign: str, other, reverse: bool = False) -> Text:
        left, right = (Text.of(other), self) if reverse else (self, Text.of(other))
        return Text(f"({left.code}{sign}{right.code})")

    def __neg__(self):
        return Text(f"(-{self.code})")

    def __add__(self, other):
        return self._joined("+", other)

    def __radd__(self, other):
        return self._joined("+", other, reverse=True)

    def __sub__(self, other):
        return self._joined("-", other)

    def __rsub__(self, other):
        return self._joined("-", other, reverse=True)

    def __mul__(self, other):
        return self._joined("*", other)

    def __rmul__(self, other):
        return self._joined("*", other, reverse=True)

    def __truediv__(self, other):
        return self._joined("/", other)

    def __rtruediv__(self, other):
        return self._joined("/", other, reverse=True)

    def __pow__(self, n: int):
        if n < 0:
            return 1.0 / self**-n
        if n < 2:
            return self if n else Text("1")
        if self.is_coordinate and n <= PRODUCT:
            return Text(f"({'*'.join([self.code] * n)})")
        return Text(f"pow({self.code},{n})")

    # --- elementary functions, under the names that numbers/functions.py asks for -----------------------------------
    def _called(self, name: str, *others) -> Text:
        return Text(f"{name}({','.join(Text.of(v).code for v in (self, *others))})")

    def sqrt(self):
        return self._called("sqrt")

    def cbrt(self):
        return self._called("Cbrt")

    def sin(self):
        return self._called("sin")

    def cos(self):
        return self._called("cos")

    def tan(self):
        return self._called("tan")

    def exp(self):
        return self._called("exp")

    def log(self):
        return self._called("ln")

    def power(self, exponent):
        return self._called("pow", exponent)

    def power_of(self, base):
        return Text.of(base).power(self)

    def absolute(self):
        return self._called("abs")

    def floor(self):
        return self._called("floor")

    def heaviside(self):
        return Text(f"select({self.code},0,1)")

    def atan2(self, x):
        return self._called("atan2", x)

    def atan2_of(self, y):
        return Text.of(y).atan2(self)

    @staticmethod
    def composed(name: str, arguments) -> Text:
        return Text(f"{name.capitalize()}({','.join(Text.of(a).code for a in arguments)})")

    def minimum(self, other):
        return self._called("min", other)

    def maximum(self, other):
        return self._called("max", other)


def declared() -> str:
    """What functions have to be declared: those that SDL lacks, or means otherwise, as they are made of others here."""
    arguments = [Text(name) for name in "abc"]  # t is the clock's, u and v are a parametric surface's
    lines = [CBRT]
    for name, (function, arity) in composed.FUNCTIONS.items():
        body = function.__wrapped__(*arguments[:arity]).code
        lines.append(f"#declare {name.capitalize()} = function({','.join('abc'[:arity])}) {{ {body} }};")
    return "\n".join(lines)


def function_text(surface) -> str:
    """The regular form of `surface` in its own frame, as an SDL expression of x, y, z; negative inside where f is."""
    return Text.of(surface.regular_form(*Text.coordinates(), **surface.parameters)).code
