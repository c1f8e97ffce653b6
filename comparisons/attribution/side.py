"""One side of an attribution: a renderer that makes pictures, and tells a pixel's rays if it can."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from importlib import import_module

from reference_tracer.tracer.render import Picture
from reference_tracer.scene.model import Scene

from .. import renderers
from . import history, wrong
from .records import History


@dataclass(frozen=True)
class Side:
    """Called with a scene, it makes the picture."""

    title: str
    make: Callable[[Scene], Picture]
    rays: Callable[[Scene, int, int], History] | None = None  # of the pixel in that row and column; None: not told

    def __call__(self, scene: Scene) -> Picture:
        return self.make(scene)


def of_renderer(name: str) -> Side:
    """A renderer of the suite. Raises InputError for an unknown one."""
    renderer = renderers.find(name)
    # a derived scene may have none of the native shapes that its scene has
    quick = {"reference": {"repeat": False}, "mitsuba": {"repeat": False, "require_native": False}}
    settings = {**renderer.settings, **quick.get(renderer.module, {})}
    make = lambda scene: renderers.render(name, scene, settings)
    if renderer.module == "reference":
        rays = lambda scene, row, col: history.ours(scene, row, col, renderer.settings["method"], renderer.title)
    elif renderer.module == "mitsuba":
        from . import mitsuba_history  # Mitsuba is imported only where it is used

        shapes = {k: v for k, v in renderer.settings.items() if k in ("shapes", "resolution")}
        rays = lambda scene, row, col: mitsuba_history.rays(scene, row, col, renderer.title, **shapes)
    else:
        rays = None
    return Side(renderer.title, make, rays)


def of_fault(id: str) -> Side:
    """The reference tracer with a fault put into it, or as it is if `id` is empty. Raises InputError."""
    if not id:
        return of_renderer("exact")
    f = wrong.fault(id)
    title = f"reference, wrong on purpose: {f.title}"

    def make(scene: Scene) -> Picture:
        with wrong.in_place(f):
            return import_module("reference_tracer.tracer.render").render(scene, "exact")

    def rays(scene: Scene, row: int, col: int) -> History:
        with wrong.in_place(f):
            return history.ours(scene, row, col, "exact", title)

    return Side(title, make, rays)


def of_function(make: Callable[[Scene], Picture], title: str) -> Side:
    """Any function that makes pictures."""
    if isinstance(make, Side):
        return make
    return Side(title, make)
