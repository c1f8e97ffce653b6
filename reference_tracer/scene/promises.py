"""What a scene promises of its formulas: that the surface lies within the `bounds` given. Checked when a scene is read."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..surfaces import Clipped, Expression
from ..surfaces.outside import Outside, outside
from .placement import reach_in_frame

if TYPE_CHECKING:
    from .model import Object, Scene

MOST_SEARCHES = 32  # of the part of space that rays reach, where a formula has several signs or none that is known


def promised(obj: Object) -> Expression | None:
    """The formula of `obj` if it has bounds."""
    surface = obj.surface.of if isinstance(obj.surface, Clipped) else obj.surface
    return surface if isinstance(surface, Expression) and surface.bounds else None


def unproven(scene: Scene) -> list[str]:
    """The objects whose bounds are promised and not proven: no method relies on those."""
    return [f"{obj.name or obj.surface.type} (object {k})" for k, obj in enumerate(scene.objects)
            if (surface := promised(obj)) and surface.box() is None]


def broken(scene: Scene) -> str:
    """The first bounds that provably do not hold their surface, and what to do; "" where there are none."""
    searches = 0
    for k, obj in enumerate(scene.objects):
        surface = promised(obj)
        if surface is None or surface.sign_outside:
            continue
        box, length = surface.bounds.corners, len(surface.formula)
        found = outside(surface, box, length=length)
        if not found.face:
            searches += 1
            if searches > MOST_SEARCHES:
                continue
            found = outside(surface, box, tuple(map(tuple, reach_in_frame(scene, obj).tolist())), length)
        if found.change:
            return f"objects[{k}].surface.bounds{_named(obj)} do not hold the surface: {_told(found)}"
    return ""


def _named(obj: Object) -> str:
    return f" ({obj.name})" if obj.name else ""


def _told(found: Outside) -> str:
    point = lambda p: "(" + ", ".join(f"{c:.5g}" for c in p) + ")"
    positive, negative = map(point, found.change)
    where = f"on the face {found.face}" if found.face else "outside of them, where rays get"
    return (f"f > 0 at {positive} and f < 0 at {negative}, both {where}; give bounds that hold all of it, or \"clip\" in "
            "place of \"bounds\" if the solid shall end there")
