"""Small pictures of a formula: its function is carried out as a program, in a kernel that all formulas share.

LLVM takes about a second for a formula's own kernel, three times as long for the interpreter's, but for that only once. It
is several times slower for every ray, so that larger pictures have kernels of their own, as have scenes with secondary rays,
of which every generation has one. What is traced is the same function, with the same roundings and enclosures.
"""

from __future__ import annotations

from collections.abc import Hashable
from functools import cached_property

from ..scene.model import Object, Scene
from ..surfaces import Clipped, Expression
from ..surfaces.interpreted import Interpreted, programs_of
from .world import World

MOST_RAYS = 20_000  # camera rays: for about twice as many the interpreter takes as long as compiling does
# what kernels read at run time, or never, under the methods that are interpreted
NUMBERS = {"max_distance", "step_size", "tolerance", "max_iterations", "cutoff"}


def is_interpreted(obj: Object) -> bool:
    """Whether the surface of `obj` is a formula, clipped or not, that the interpreter can carry out."""
    formula = obj.surface.of if isinstance(obj.surface, Clipped) else obj.surface
    return isinstance(formula, Expression) and obj.first_hit is None and programs_of(obj.surface) is not None


def worth_it(scene: Scene, method: str) -> bool:
    """Whether the interpreter traces `scene`: a small picture of one formula, nothing of it reflecting or transparent."""
    camera, samples = scene.camera, scene.tracing.samples
    return (method == "exact" and scene.tracing.precision == 64 and camera.width * camera.height * samples**2 <= MOST_RAYS
            and not any(o.material.reflection or o.material.transparency for o in scene.objects)
            and sum(map(is_interpreted, scene.objects)) == 1)


class InterpretingWorld(World):
    """A world in which formulas are interpreted."""

    def traced(self, obj: Object) -> Object:
        if not is_interpreted(obj):
            return obj
        return obj.model_copy(update={"surface": Interpreted(obj.surface, self.arrays)})

    @cached_property
    def structure(self) -> Hashable:
        """All that its kernels depend on: worlds with the same share what is recorded."""
        scene, families = self.scene, []
        for family in self.families:
            shape = (tuple(family.indices), family.sign_outside, family.rotated, family.flipped, family.casts_shadow,
                     family.method.name)
            own = [scene.objects[k] for k in family.indices]
            families.append((*shape, *("" if is_interpreted(o) else o.surface.model_dump_json() for o in own)))
        return self.method, scene.tracing.model_dump_json(exclude=NUMBERS), any(scene.background), tuple(families)
