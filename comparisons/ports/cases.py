"""What a port is asked: test vectors, small pictures of every shipped scene, and of scenes as the figures have them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cache

from raytruth.reference_tracer.errors import InputError
from raytruth.reference_tracer.scene import library
from raytruth.reference_tracer.scene.model import Scene
from raytruth.reference_tracer.tracer.given_rays import GivenRays

from . import vectors
from .protocol import LEVELS, Declaration, Level

SIZE = (48, 36)
SIZES = {4: (24, 18), 16: (8, 6)}  # by the samples of a pixel
CONVEX = ("plane", "sphere", "ellipsoid")


@dataclass(frozen=True)
class Case:
    """A picture of `scene`, or what `rays` meet in it, at one level of truth."""

    name: str
    level: Level
    scene: Scene
    section: str
    rays: GivenRays | None = None
    ids: tuple[str, ...] = field(default=(), compare=False)  # of the rays

    @property
    def id(self) -> str:
        return f"{self.level}:{self.name}"

    @property
    def needs(self) -> dict[str, set[str]]:
        """The surfaces, effects and switches that a port must know to answer."""
        scene = self.scene
        kinds = {obj.surface.type for obj in scene.objects}
        effects = {word for word, needed in (
            ("shadow", scene.lights and not (len(scene.objects) == 1 and kinds <= set(CONVEX))),
            ("reflection", any(o.material.reflection > 0 for o in scene.objects)),
            ("refraction", any(o.material.transparency > 0 for o in scene.objects)),
            ("multisampling", scene.tracing.samples > 1), ("rotation", any(o.rotation for o in scene.objects))) if needed}
        return {"surface": kinds, "effect": effects, "switch": set(scene.switches)}

    def lacks(self, port: Declaration) -> str | None:
        """Why `port` is not asked this, in words; None if it is."""
        if self.level not in port.levels:
            return f"the port does not claim the {self.level}'s truth"
        known = {"surface": port.surfaces, "effect": port.effects, "switch": port.switches}
        missing = [f"{kind} {word}" for kind, words in self.needs.items() for word in sorted(words - set(known[kind]))]
        return f"the port does not claim {', '.join(missing)}" if missing else None


@cache
def cases() -> tuple[Case, ...]:
    """All of them, of both levels; those a beginner passes first come first."""
    asked = [(group.id, group.scene, group.section, group.rays, tuple(v.id for v in group.vectors))
             for group in vectors.groups()]
    asked += [(f"scenes/{name}", small(library.scene(name)), "7", None, ()) for name in (*library.effects(), *library.names())]
    asked += [(f"scenes/{scene.name}", scene, "7", None, ()) for scene in _as_in_the_figures()]
    return tuple(Case(name, level, scene, section, rays, ids) for level in LEVELS for name, scene, section, rays, ids in asked)


def small(scene: Scene) -> Scene:
    return scene.resized(*SIZES.get(scene.tracing.samples, SIZE))


def _as_in_the_figures():
    """Scenes of the document with one switch each (decisions E1, F1 to F5), at the size of the other pictures."""
    figure = lambda number: small(library.scene(next(n for n in library.names() if n.startswith(f"figure-{number}"))))
    for name, scene, changes in (("misprint", figure("15"), {"refraction": "as_printed"}),
                                 ("balanced", figure("17"), {"lights": "balanced", "ambient": 0.1}),
                                 ("opaque-only", figure("13"), {"shadows": "opaque_only"}),
                                 ("range-of-a-path", figure("18"), {"range": "path"})):
        yield scene.traced_with(**changes).model_copy(update={"name": f"{scene.name}-{name}"})
    room = figure("19")
    yield room.seen_by(v_x=(1.0, 0.0, 0.0), v_y=(0.0, 1.0, 0.0)).model_copy(update={"name": f"{room.name}-oblique"})


def chosen(names: Sequence[str]) -> tuple[Case, ...]:
    """The cases called, or whose ids begin with, `names`; all if there are none. Raises InputError."""
    found = []
    for name in names or ("",):
        here = [case for case in cases() if case.id.startswith(name) or case.name.startswith(name)]
        exact = [case for case in here if name in (case.id, case.name)]
        if not here:
            raise InputError(f"there is no case {name!r}; 'raytruth check-port --list' names them")
        found += [case for case in exact or here if case not in found]
    return tuple(found)
