"""Constructive solid geometry: the union, the intersection or the difference of solids, formulas and shipped surfaces alike."""

from __future__ import annotations

from functools import cached_property, reduce
from typing import TYPE_CHECKING, ClassVar, Literal

from pydantic import Field

from ..numbers import functions as fn
from .surface import Surface

if TYPE_CHECKING:
    from . import AnySurface  # known when all kinds are: see there

MOST_PARTS = 32


class Csg(Surface):
    """Solids joined: the least of their f (union), the largest (intersection), or the first without the others (difference).

    Each part has its own `center`, relative to that of the whole, `inside` and `clip`.
    """

    type: Literal["csg"] = "csg"
    operation: Literal["union", "intersection", "difference"]
    of: tuple[AnySurface, ...] = Field(min_length=2, max_length=MOST_PARTS, description="the solids, surfaces of any type")

    title: ClassVar[str] = "Solids joined"
    equation: ClassVar[str] = "min(f, g) = 0, max(f, g) = 0 or max(f, −g) = 0"

    @cached_property
    def function(self):
        return self._joined([part.function for part in self.of])

    @cached_property
    def regular_form(self):
        return self._joined([part.regular_form for part in self.of])

    def _joined(self, forms):
        join = fn.minimum if self.operation == "union" else fn.maximum
        flips = [(part.inside == "positive") != (self.operation == "difference" and k > 0) for k, part in enumerate(self.of)]
        names = [tuple(part.parameters) for part in self.of]

        def joined(x, y, z, **numbers):
            values = []
            for k, (form, flipped) in enumerate(zip(forms, flips)):
                place = (fn.sub(v, numbers[f"{name}{k}"]) for v, name in zip((x, y, z), "xyz"))
                value = form(*place, **{name: numbers[f"{name}_{k}"] for name in names[k]})
                values.append(-value if flipped else value)
            return reduce(join, values)

        return joined

    @property
    def parameters(self):
        return {name: number for k, part in enumerate(self.of)
                for name, number in (*((f"{axis}{k}", c) for axis, c in zip("xyz", part.center)),
                                     *((f"{own}_{k}", number) for own, number in part.parameters.items()))}

    @property
    def drowns(self):
        return any(part.drowns for part in self.of)

    @property
    def family(self):
        parts = (f"{'outside of ' if part.inside == 'positive' else ''}{part.family}" for part in self.of)
        return f"{self.operation} of ({'; '.join(parts)})"

    def box(self):
        """Around all parts of a union, all of which must be bounded; within each that is bounded of an intersection; around
        the first of a difference."""
        boxes = [self._box_of(part) for part in (self.of[:1] if self.operation == "difference" else self.of)]
        if self.operation == "union":
            return None if None in boxes else _spanned(boxes, min, max)
        known = [box for box in boxes if box]
        if not known:
            return None
        low, high = _spanned(known, max, min)
        return (low, high) if all(a < b for a, b in zip(low, high)) else known[0]

    @staticmethod
    def _box_of(part: Surface):
        if part.sign_outside != (-1 if part.inside == "positive" else 1):
            return None
        return tuple(tuple(c + v for c, v in zip(part.center, corner)) for corner in part.box())


def _spanned(boxes, least, most):
    lows, highs = zip(*boxes)
    return tuple(map(least, zip(*lows))), tuple(map(most, zip(*highs)))
