"""Small pictures of formulas: their functions are carried out as programs, in a kernel that all formulas share.

A formula's own kernel takes LLVM as long as an interpreter's, but the interpreter's is compiled once. It is slower for every
ray, so that larger pictures have kernels of their own. What is traced is the same function with the same roundings.
"""

from __future__ import annotations

from collections.abc import Hashable
from functools import cached_property

from ..scene.model import Object, Scene
from ..surfaces import Clipped, Csg, Expression
from ..surfaces.interpreted import Interpreted, programs_of
from .world import World

MOST_RAYS = 20_000  # camera rays of a picture that is traced so; `raytruth bench formulas` shows both sides of it


def is_interpreted(obj: Object) -> bool:
    return isinstance(obj.surface, (Expression, Csg, Clipped)) and obj.first_hit is None and programs_of(obj.surface) is not None


def worth_it(scene: Scene, method: str) -> bool:
    """Whether `scene` is traced by an interpreter."""
    camera, tracing = scene.camera, scene.tracing
    return (method == "exact" and camera.width * camera.height * tracing.samples**2 <= MOST_RAYS
            and any(map(is_interpreted, scene.objects)))


class InterpretingWorld(World):
    """A world in which formulas are interpreted."""

    def traced(self, obj: Object) -> Object:
        if not is_interpreted(obj):
            return obj
        number = sum(map(is_interpreted, self.scene.objects[:self.scene.objects.index(obj)]))
        return obj.model_copy(update={"surface": Interpreted(obj.surface, f"interpreted {number}", self.arrays)})

    @cached_property
    def structure(self) -> Hashable:
        """All that its kernels depend on: worlds with the same share what is recorded."""
        scene, families = self.scene, []
        for family in self.families:
            shape = (tuple(family.indices), family.sign_outside, family.rotated, family.flipped, family.casts_shadow,
                     family.method.name)
            own = [scene.objects[k] for k in family.indices]
            families.append((*shape, *("" if is_interpreted(o) else o.surface.model_dump_json() for o in own)))
        return (self.method, scene.tracing.model_dump_json(), any(scene.background), self.reflective, self.transparent,
                tuple(families))
