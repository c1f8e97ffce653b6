"""The renderers that can be compared: one file a renderer, found by its name here.

To add a renderer: write a file with a function `render(scene, **settings) -> Picture` and an entry in RENDERERS, which
says what of `tracing` it cannot express: it is compared on the nearest scene that it can (`nearest`). The
picture's metadata tells `build`, `first` and `warm` seconds where the renderer has such phases.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from importlib import import_module
from inspect import signature
from typing import get_type_hints

from pydantic import ConfigDict, TypeAdapter, ValidationError

from raytruth.reference_tracer.errors import InputError
from raytruth.reference_tracer.scene.model import Scene
from raytruth.reference_tracer.tracer.render import Picture

from ..execution.code import installed, program
from . import expressible
from .expressible import EMBREE, MITSUBA, POVRAY, Lack, Nearest


@dataclass(frozen=True)
class Renderer:
    """`module` is imported only in the process that runs the renderer; `program` is what it starts, `package` what it
    reaches through another one."""

    name: str
    title: str
    module: str
    settings: dict = field(default_factory=dict)
    program: str = ""
    package: str = ""
    lacks: tuple[Lack, ...] = ()  # what of a scene it cannot express

    @property
    def code(self) -> tuple[str, ...]:
        """The modules that its pictures are made by."""
        return f"{__name__}.{self.module}", "raytruth.reference_tracer.tracer.image_files"

    @property
    def content(self) -> list:
        """What else can change its pictures."""
        return [self.name, self.settings, self.program and program(self.program), self.package and installed(self.package)]


RENDERERS = {r.name: r for r in (
    Renderer("exact", "reference, exact intersections", "reference", {"method": "exact"}),
    Renderer("paper", "reference, the document's literal method", "reference", {"method": "paper"}),
    Renderer("mitsuba-native", "Mitsuba 3, native shapes", "mitsuba",
             {"shapes": "native", "resolution": 256, "require_native": True}, lacks=MITSUBA),
    Renderer("mitsuba-mesh", "Mitsuba 3, meshes", "mitsuba", {"shapes": "mesh", "resolution": 256}, lacks=MITSUBA),
    Renderer("mitsuba-refined", "Mitsuba 3, hits moved onto f", "mitsuba",
             {"shapes": "native", "resolution": 256, "refined": True}, lacks=MITSUBA),
    Renderer("mitsuba-sdfgrid", "Mitsuba 3, grids", "mitsuba", {"shapes": "sdfgrid", "resolution": 128}, lacks=MITSUBA),
    Renderer("embree", "Embree, meshes", "embree", {"resolution": 256}, package="embreex", lacks=EMBREE),
    Renderer("raysect", "raysect, its own primitives", "raysect", package="raysect", lacks=EMBREE),
    Renderer("povray", "POV-Ray 3.7, its own primitives", "povray", {"shapes": "native", "accuracy": 1e-8}, "povray",
             lacks=POVRAY),
    Renderer("povray-isosurface", "POV-Ray 3.7, isosurfaces", "povray", {"shapes": "isosurface", "accuracy": 1e-8}, "povray",
             lacks=POVRAY),
)}


def find(name: str) -> Renderer:
    """The renderer called `name`. Raises InputError."""
    if name not in RENDERERS:
        raise InputError(f"unknown renderer {name!r}; choose one of {', '.join(RENDERERS)}")
    return RENDERERS[name]


def nearest(scene: Scene, *names: str) -> Nearest:
    """The scene nearest to `scene` that all renderers called `names` can express, and what is otherwise in it."""
    return expressible.nearest(scene, [(find(name).title.partition(",")[0], find(name).lacks) for name in names])


def parsed(name: str, settings: dict[str, str]) -> dict:
    """Settings of renderer `name` as typed, each as the kind of value that its `render` says it takes. Raises InputError."""
    from raytruth.reference_tracer.scene.load import one_line

    module = import_module(f"{__name__}.{find(name).module}")
    kinds, found = get_type_hints(module.render, include_extras=True), {}
    _require_known(name, module, settings)
    for key, text in settings.items():
        kind = TypeAdapter(kinds[key], config=ConfigDict(allow_inf_nan=False))
        try:
            found[key] = kind.validate_python(None if text in ("null", "None") and type(None) in getattr(
                kinds[key], "__args__", ()) else text)
        except ValidationError as error:
            raise InputError(f"{name}, setting {key}={text[:60]}: {one_line(error).removeprefix('the scene: ')}") from None
    return found


def _require_known(name: str, module, settings) -> None:
    known = set(signature(module.render).parameters) - {"scene"}
    if unknown := sorted(set(settings) - known):
        raise InputError(f"{name}: has no setting {unknown[0]!r}; it has {', '.join(sorted(known))}")


def render(name: str, scene: Scene, settings: dict | None = None) -> Picture:
    """The picture that renderer `name` makes of `scene`. Raises InputError, and UnsupportedError with a reason."""
    renderer = find(name)
    module = import_module(f"{__name__}.{renderer.module}")
    chosen = {**renderer.settings, **(settings or {})}
    _require_known(name, module, chosen)
    return module.render(scene, **chosen)
