"""A hundred spheres against ten that cover as much of the picture."""

from __future__ import annotations

import math

from reference_tracer.scene.model import Camera, Light, Material, Object, Scene
from reference_tracer.surfaces.plane import Plane
from reference_tracer.surfaces.sphere import Sphere

from ..contestants import tracer
from ..options import Options
from ..results import Row
from ..timing import row, take_turns

NAME = "objects"
CASES = ("spheres",)
FEW, MANY = 10, 100
BAR = 4.0


def measure(case: str, options: Options) -> list[Row]:
    size = (320, 240) if options.quick else (640, 480)
    rows = []
    for method in ("exact", "paper"):
        measured = take_turns([tracer(f"{n} spheres", spheres(n, *size), method) for n in (FEW, MANY)],
                              options.turns, options.budget)
        rows.append(row(f"{NAME}/{method}", f"{MANY} spheres / {FEW} spheres, {method}", measured, f"{MANY} spheres",
                        f"{FEW} spheres", BAR if method == "exact" else None, options.clock, sense="<=",
                        picture=f"{size[0]} x {size[1]}", note="mirrors above a floor"))
    return rows


def spheres(count: int, width: int, height: int) -> Scene:
    """`count` mirroring balls in rows above a floor, whose area in the picture is about the same for any count."""
    columns = round(math.sqrt(count * 2))
    spacing = 6 / columns
    rows = math.ceil(count / columns)
    balls = [Object(surface=Sphere(center=((k % columns - (columns - 1) / 2) * spacing,
                                           (k // columns - (rows - 1) / 2) * spacing, 7 + 0.5 * math.sin(2.4 * k)),
                                   r=0.4 * spacing),
                    material=Material(color=(0.9, 0.5 + 0.4 * math.cos(k), 0.3), reflection=0.3))
             for k in range(count)]
    floor = Object(surface=Plane(center=(0.0, -2.5, 0.0), a=0.0, b=1.0, c=0.0))
    return Scene(name=f"spheres-{count}", camera=Camera(width=width, height=height), objects=(floor, *balls),
                 lights=(Light(position=(3.0, 5.0, 0.0)), Light(position=(-4.0, 4.0, 1.0), brightness=(0.4, 0.4, 0.4))))
