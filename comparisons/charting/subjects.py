"""On what is charted: the document's scenes, and single surfaces that are hard for one method or another."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from reference_tracer.scene import library
from reference_tracer.scene.model import Camera, Light, Material, Object, Scene, Tracing
from reference_tracer.surfaces.expression import Expression

BRIEF_SCENES = ("figure-07-torus", "figure-09-heart", "figure-reflection")
BRIEF_SURFACES = ("surface-blob",)
GOLDEN = "((1 + sqrt(5)) / 2) ** 2"
BALL = "(x**2 + y**2 + z**2 - 1)"

# name: title, formula, radius of the camera's distance
FORMULAS = {
    "surface-barth-sextic": (
        "Barth’s sextic: 65 double points",
        "4 * ({g} * x**2 - y**2) * ({g} * y**2 - z**2) * ({g} * z**2 - x**2) - (2 + sqrt(5)) * {b}**2", 3.2),
    "surface-thin-shell": ("A shell of thickness 0.01", "{b}**2 - 0.0001", 3.0),
    "surface-thinner-shell": ("A shell of thickness 0.001", "{b}**2 - 0.000001", 3.0),
    "surface-gyroid": ("Gyroid: no polynomial",
                       "sin(3*x)*cos(3*y) + sin(3*y)*cos(3*z) + sin(3*z)*cos(3*x)", 3.0),
    "surface-blob": ("Two melting balls: exponentials",
                     "0.3 - exp(-4 * ((x - 0.6)**2 + y**2 + z**2)) - exp(-4 * ((x + 0.6)**2 + y**2 + z**2))", 3.0),
}


@dataclass(frozen=True)
class Charted:
    """A scene at the size it is charted at, with one sample a pixel: every contestant traces the same rays."""

    scene: Scene
    kind: Literal["scene", "surface"]


def surface(name: str) -> Scene:
    """The single surface called `name` in front of a camera, lit by one light, with nothing known of its extent."""
    title, formula, distance = FORMULAS[name]
    return Scene(name=name, title=title, camera=Camera(position=(0.0, 0.0, -distance), fov=50.0),
                 objects=(Object(surface=Expression(type="expression", center=(0.0, 0.0, 0.0),
                                                    formula=formula.format(g=GOLDEN, b=BALL)),
                                 material=Material(color=(0.9, 0.7, 0.4))),),
                 lights=(Light(position=(3.0, 4.0, -6.0)),), tracing=Tracing(max_distance=2.0 * distance))


def chosen(names: list[str], full: bool, size: tuple[int, int]) -> list[Charted]:
    """The subjects called `names`, or paths of scene files; without names, a few or (`full`) all. Raises InputError."""
    if not names:
        names = [*library.names(), *FORMULAS] if full else [*BRIEF_SCENES, *BRIEF_SURFACES]
    return [_sized(surface(name) if name in FORMULAS else library.find(name), size) for name in dict.fromkeys(names)]


def _sized(scene: Scene, size: tuple[int, int]) -> Charted:
    return Charted(scene.resized(*size, samples=1), "surface" if len(scene.objects) == 1 else "scene")
