"""What of a solid lies within a box: its own function joined with the distances from the box's faces."""

from __future__ import annotations

from functools import cached_property
from typing import ClassVar

from ..numbers import functions as fn
from .surface import Surface

LIMITS = ("low_x", "low_y", "low_z", "high_x", "high_y", "high_z")


class Clipped(Surface):
    """The solid of `of` within its clip box: max(f, low − p, p − high) < 0, −f in place of f where f > 0 is inside.

    No kind of its own in a scene file: a surface whose `clip` is given becomes one when the scene is read, and is
    written as it was. Whoever knows better ways with the surface's kind therefore does not take it for one of those,
    and everything else follows from this one function.
    """

    of: Surface

    title: ClassVar[str] = "Clipped solid"
    equation: ClassVar[str] = "max(f, low − p, p − high) = 0"

    @staticmethod
    def made(surface: Surface) -> Surface:
        """`surface`, clipped where it says so."""
        if surface.clip is None or isinstance(surface, Clipped):
            return surface
        return Clipped(type=f"clipped {surface.type}", center=surface.center, clip=surface.clip,
                       of=surface.model_copy(update={"clip": None}))

    @property
    def written(self) -> Surface:
        """The surface as a scene file has it."""
        return self.of.model_copy(update={"center": self.center, "clip": self.clip})

    @staticmethod
    def document(surface: Surface, handler) -> dict:
        """`surface` as a scene file has it; one that is not clipped is written, and hashed, without the key."""
        document = handler(surface.written if isinstance(surface, Clipped) else surface)
        if document.get("clip", ...) is None:
            del document["clip"]
        return document

    @cached_property
    def function(self):
        return self._cut(self.of.function)

    @cached_property
    def regular_form(self):
        return self._cut(self.of.regular_form)

    def _cut(self, form):
        flipped = self.of.inside == "positive"

        def cut(x, y, z, *, low_x, low_y, low_z, high_x, high_y, high_z, **own):
            value = form(x, y, z, **own)
            value = -value if flipped else value
            for p, low, high in ((x, low_x, high_x), (y, low_y, high_y), (z, low_z, high_z)):
                value = fn.maximum(value, fn.maximum(p - high, -(p - low)))
            return value

        return cut

    @property
    def drowns(self):
        return self.of.drowns

    @property
    def parameters(self):
        return {**dict(zip(LIMITS, (*self.clip.low, *self.clip.high))), **self.of.parameters}

    @property
    def family(self):
        return f"clipped {'outside of ' if self.of.inside == 'positive' else ''}{self.of.family}"

    def box(self):
        """The clip box, or what it has in common with that of a bounded solid."""
        if self.of.sign_outside != (-1 if self.of.inside == "positive" else 1):
            return self.clip.corners
        low, high = (tuple(map(pick, *ends)) for pick, *ends in zip((max, min), self.clip.corners, self.of.box()))
        return (low, high) if all(a < b for a, b in zip(low, high)) else self.clip.corners
