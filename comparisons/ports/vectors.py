"""Test vectors: rays, and pictures of a few pixels, each with an id that is never reused.

A group is a scene and what is asked of it. Rays are written as they were chosen, by a decision's corner or at random once;
`ids.txt` lists every id with a checksum of its question, so that none changes its meaning unnoticed. What is expected is
not written here: the reference answers (truth.py).
"""

from __future__ import annotations

import hashlib
import json
import math
import random
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np

from raytruth.reference_tracer.scene.model import Scene
from raytruth.reference_tracer.tracer.given_rays import GivenRays

VERSION = "1.0.0"
IDS = Path(__file__).with_name("ids.txt")

FLAGS = {
    "random": "an ordinary ray, drawn once; an error here is one of the equation or of the root",
    "inside": "begins within the solid; a port that starts every ray outside goes wrong (M2, M3)",
    "axis": "along an axis of the surface, where closed forms are short",
    "thin": "crosses less than one step of the solid: the algorithm as written may step over it, the model may not (4.1)",
    "grazing": "close to a tangent: the root is badly conditioned, the bounds are wide",
    "range": "about the end of the ray at max_distance (M5)",
    "singular": "meets the heart where the gradient of its printed form vanishes (O5): Newton converges slowly or away",
    "tie": "two surfaces lie within one step, or at one distance (M4)",
    "light": "the sum over lights, a light that is behind, brightness per channel (L1, L2)",
    "shadow": "a shadow ray that is stopped, weakened at every crossing, or not (L3)",
    "mirror": "a reflection ray (4.3.2)",
    "entering": "refraction into the solid (R1)",
    "leaving": "refraction out of the solid, n1 and n2 swapped (R1)",
    "total": "total internal reflection, which keeps the weight of the transparency (R3)",
    "mixing": "all three colours at once (4.3.4)",
    "depth": "the last generation of secondary rays (D1)",
    "background": "what nothing is hit by (D2)",
    "switch": "as the document's figures, or its misprint, have it: only ports that declare the switch are asked",
    "camera": "a whole picture: axes, field of view, row 0, sub-pixel centres (C1, C2, F5)",
}


@dataclass(frozen=True)
class Vector:
    """One ray of a group: where it begins, its unit direction, and why it is there."""

    id: str
    o: tuple[float, float, float]
    d: tuple[float, float, float]
    flags: tuple[str, ...]


@dataclass(frozen=True)
class Group:
    """A scene, and rays, or none where its whole picture is asked for."""

    id: str
    scene: Scene
    section: str
    decisions: tuple[str, ...]
    flags: tuple[str, ...]  # of a picture
    vectors: tuple[Vector, ...] = ()

    @property
    def rays(self) -> GivenRays | None:
        return GivenRays(np.array([v.o for v in self.vectors]), np.array([v.d for v in self.vectors])) if self.vectors else None

    def questions(self) -> Iterator[tuple[str, str]]:
        """Every id with a checksum of what it asks."""
        for id, ray in [(v.id, [v.o, v.d]) for v in self.vectors] or [(self.id, [])]:
            yield id, hashlib.sha256(json.dumps([self.scene.hash, ray]).encode()).hexdigest()[:16]


@cache
def groups() -> tuple[Group, ...]:
    """All of them."""
    return (*_surfaces(), *_events(), *_switched(), *_cameras())


def listed() -> dict[str, str]:
    """The ids that have been given away, with their checksums."""
    return dict(line.split() for line in IDS.read_text(encoding="ascii").splitlines())


# --- scenes --------------------------------------------------------------------------------------------------------------
def _object(kind: str, center=(0.0, 0.0, 0.0), *, turn=None, inside="negative", color=(1.0, 1.0, 1.0), mirror=0.0, T=0.0, n=1.0,
            **parameters) -> dict:
    numbers = {name: float(value) for name, value in parameters.items()}
    obj = {"surface": {"type": kind, "center": tuple(map(float, center)), "inside": inside, **numbers},
           "material": {"color": tuple(map(float, color)), "reflection": mirror, "transparency": T, "refractive_index": n}}
    return obj | ({"rotation": {"axis": tuple(map(float, turn[0])), "degrees": float(turn[1])}} if turn else {})


def _scene(name: str, objects: Sequence[dict], lamps=(), background=(0.0, 0.0, 0.0), camera=None, **tracing) -> Scene:
    lights = tuple({"position": tuple(map(float, p)), "brightness": tuple(map(float, b))} for p, b in lamps)
    return Scene.model_validate({"name": name, "objects": tuple(objects), "lights": lights, "background": background,
                                 "camera": {"width": 2, "height": 1, **(camera or {})}, "tracing": tracing})


def _unit(v) -> tuple[float, float, float]:
    length = math.sqrt(sum(c * c for c in v))
    return tuple(c / length for c in v)


def _towards(o, target) -> tuple[tuple, tuple]:
    """The ray from `o` through `target`."""
    return tuple(map(float, o)), _unit([b - a for a, b in zip(o, target)])


def _numbered(group: str, rays: Sequence[tuple[tuple, tuple, Sequence[str]]]) -> tuple[Vector, ...]:
    return tuple(Vector(f"{group}/{k:02d}", o, d, tuple(flags)) for k, (o, d, flags) in enumerate(rays, 1))


# --- single surfaces (sections 4.1, 4.2, 7.1) ------------------------------------------------------------------------------
def _surfaces() -> Iterator[Group]:
    slanted, quarter = ((1, 2, 0.5), 40), ((1, 0, 0), 90)
    kinds = {
        "plane": (_object("plane", (0.2, -0.5, 4), a=0.3, b=1, c=-0.2), 1.0, "7.1.1", ("O1", "O2")),
        "sphere": (_object("sphere", (0.3, -0.2, 4), r=1.2), 1.2, "7.1.2", ("O1", "M1")),
        "ellipsoid": (_object("ellipsoid", (0.1, 0.2, 4.5), a=1.5, b=0.7, c=1.1), 1.1, "7.1.3", ("O1",)),
        "ellipsoid-turned": (_object("ellipsoid", (0, 0, 4), turn=((0.2, -1, 0.6), 123.4), a=1.5, b=0.4, c=0.9), 0.9, "7",
                             ("O3",)),
        "torus": (_object("torus", (-0.1, 0.1, 4), R=1.3, r=0.4), 1.5, "7.1.4", ("O4",)),
        "torus-quarter-turn": (_object("torus", (0, 0, 4), turn=quarter, R=1.3, r=0.3), 1.5, "7.1.4", ("O3", "O4")),
        "torus-turned": (_object("torus", (0.5, 0, 4), turn=slanted, R=1.1, r=0.35), 1.3, "7.1.4", ("O3", "O4")),
        "torus-overlapping": (_object("torus", (0, 0, 4), R=0.6, r=0.9), 1.3, "7.1.4", ("O4",)),
        "paraboloid": (_object("paraboloid", (0, -0.4, 4), a=0.8, b=1.2), 1.0, "7.1.5", ("O2",)),
        "heart": (_object("heart", (0, -0.1, 3)), 1.0, "7.1.6", ("O5", "M6")),
        "heart-turned": (_object("heart", (0, 0, 3), turn=slanted), 1.0, "7.1.6", ("O3", "O5")),
        "sphere-inside-out": (_object("sphere", (0.3, -0.2, 4), inside="positive", r=1.2), 1.2, "3", ("O1",)),
    }
    for name, (obj, size, section, decisions) in kinds.items():
        rays = [*_drawn(name, obj, size), *_chosen(name, obj)]
        yield Group(f"surfaces/{name}", _scene(f"vectors-{name}", [obj]), section, ("M1", "M2", "M6", "N1", *decisions), (),
                    _numbered(f"surfaces/{name}", rays))


def _drawn(name: str, obj: dict, size: float):
    """Twenty rays from around the surface towards it, four that begin near its centre; three decimals each."""
    draw, center = random.Random(f"vectors 1 {name}"), obj["surface"]["center"]
    around = lambda radius: [round(c + radius * w, 3) for c, w in zip(center, _unit([draw.gauss(0, 1) for _ in range(3)]))]
    for _ in range(20):
        yield *_towards(around(5), around(size * draw.uniform(0, 1.1))), ("random",)
    for _ in range(4):
        yield *_towards(around(0.25 * size), around(4)), ("random", "inside")


def _chosen(name: str, obj: dict):
    """The corners of decisions."""
    x0, y0, z0 = obj["surface"]["center"]
    along_z = lambda x, y, z=-3.0: ((x, y, z), (0.0, 0.0, 1.0))
    if name in ("sphere", "sphere-inside-out"):
        r = obj["surface"]["r"]
        yield *along_z(x0, y0), ("axis",)
        yield (x0, y0, z0), (0.0, 1.0, 0.0), ("axis", "inside")
        # from 0.05 on, so that the middle of each chord lies between two samples
        for chord in (0.3, 0.09, 0.04, 0.01):
            x = x0 + math.sqrt(r * r - chord * chord / 4)
            yield *along_z(x, y0, 0.05), ("grazing", *(("thin",) if chord < 0.1 else ()))
        yield *along_z(x0, y0, z0 - r - 29.9), ("range",)
        yield *along_z(x0, y0, z0 - r - 30.2), ("range",)
    elif name == "plane":
        yield (0.0, 0.0, 0.0), (0.0, -1.0, 0.0), ("axis",)
        yield (0.0, -2.0, 5.0), (0.0, 1.0, 0.0), ("axis", "inside")
    elif name == "torus":
        yield *along_z(x0, y0), ("axis",)
        yield *along_z(x0 + 1.3, y0), ("axis",)
        yield (x0 - 4, y0, z0), (1.0, 0.0, 0.0), ("axis",)
        yield (x0 + 1.3, y0, z0), (0.0, 0.0, 1.0), ("axis", "inside")
        yield *along_z(x0 + 1.3 + math.sqrt(0.16 - 0.0009), y0, -2.95), ("grazing", "thin")
        yield *_towards((x0 - 4, y0 - 0.2, z0 + 0.39), (x0 + 4, y0 - 0.2, z0 + 0.39)), ("grazing",)
    elif name == "paraboloid":
        yield (x0, y0, z0 - 3), (0.0, 0.0, 1.0), ("axis",)
        yield (x0, y0, z0 + 1), (1.0, 0.0, 0.0), ("axis", "inside")
        yield (x0 - 3.05, y0, z0 + 0.001), (1.0, 0.0, 0.0), ("grazing", "thin")
    elif name == "heart":
        for degrees in range(0, 360, 30):  # the ellipse y = 0, x^2 + 9/4 z^2 = 1
            angle = math.radians(degrees)
            point = (x0 + math.cos(angle), y0, z0 + 2 / 3 * math.sin(angle))
            yield *_towards((x0 + 4 * math.cos(angle), y0 + 1, z0 + 4 * math.sin(angle)), point), ("singular",)
        yield *along_z(x0, y0 + 1.05, 0.05), ("grazing",)
        yield *along_z(x0, y0 - 0.98, 0.05), ("grazing", "thin")


# --- one bounce, and more (sections 4.3.1 to 4.3.4) ------------------------------------------------------------------------
FLOOR = _object("plane", (0, -1, 0), a=0, b=1, c=0, color=(0.8, 0.8, 0.75))
BALLS = [_object("sphere", (-1.1, 0.3, 6), r=0.9, color=(0.9, 0.2, 0.1)),
         _object("sphere", (1.2, 0.1, 6.5), r=1, color=(0.1, 0.3, 0.9))]
LAMP = ((-3, 5, -2), (0.9, 0.9, 0.9))
DIM = ((4, 3, 1), (0.2, 0.4, 0.3))


def _fan(origin, center, radius: float, flags, count: int = 12):
    """Rays from `origin` to a disc of points about `center`, across z: a spiral of `count`."""
    for k in range(count):
        r, angle = radius * math.sqrt((k + 0.5) / count), 2.399963 * k
        target = (round(center[0] + r * math.cos(angle), 3), round(center[1] + r * math.sin(angle), 3), center[2])
        yield *_towards(origin, target), flags


def _events() -> Iterator[Group]:
    eye, at = (0.0, 0.4, -4.0), (0.0, 0.3, 1.0)
    ball = lambda **material: _object("sphere", (0, 0.3, 1), r=0.9, **material)
    sky = (0.2, 0.3, 0.5)
    make = lambda name, section, decisions, rays, objects, lights=(LAMP,), **rest: Group(
        f"events/{name}", _scene(f"vectors-{name}", objects, lights, **rest), section, decisions, (),
        _numbered(f"events/{name}", list(rays)))

    yield make("shading", "4.3.1", ("L1", "L2", "N1"), _fan(eye, at, 0.8, ("light",)), [ball(color=(0.7, 0.5, 0.9))],
               lights=[LAMP, DIM, ((0, 0.3, 9), (1, 1, 1))])
    glass_in_the_way = _object("sphere", (-1.5, 2.3, 0), r=0.5, T=0.6)
    yield make("shadow", "4.3.1", ("L2", "L3", "M3", "M5"),
               [*_fan((0, 3, -3), (0, -1, 1.5), 2.5, ("shadow",), 24),
                *_fan((-3, 5, -2.2), (-1.5, 2.3, 0), 0.4, ("shadow",), 4)],
               [FLOOR, _object("sphere", (0.7, 0.2, 1), r=0.6, color=(0.9, 0.4, 0.2)), glass_in_the_way])
    yield make("reflection", "4.3.2", ("R4", "M3", "D2"), _fan(eye, at, 0.85, ("mirror",)),
               [ball(mirror=0.7, color=(0.9, 0.9, 0.9)), FLOOR,
                _object("sphere", (1.5, 0.5, -2), r=0.7, color=(0.9, 0.2, 0.1))], background=sky)
    yield make("refraction", "4.3.3.2", ("E1", "R1", "R4", "M3"), _fan(eye, at, 0.85, ("entering", "leaving"), 16),
               [ball(T=0.9, n=1.5), FLOOR, *BALLS], background=sky)
    yield make("refraction-thinner", "4.3.3", ("R1", "R2", "R3"), _fan(eye, at, 0.88, ("entering", "total"), 16),
               [ball(T=0.9, n=0.75), FLOOR, *BALLS], background=sky)
    within = [(*_towards((0, 0.3 + y, 1), (2 * math.sin(a), 0.3 + y, 1 + 2 * math.cos(a))), ("inside", "leaving", "total"))
              for y in (0.5, 0.75) for a in (0.3, 1.1, 1.9, 2.7)]
    yield make("leaving", "4.3.3", ("R1", "R3", "M3"), within, [ball(T=0.8, n=1.6, color=(0.6, 0.9, 0.7)), FLOOR, *BALLS],
               background=sky)
    yield make("total-with-mirror", "4.3.3.1", ("R3",), within,
               [ball(mirror=0.3, T=0.8, n=1.6, color=(0.6, 0.9, 0.7)), FLOOR, *BALLS], background=sky, max_depth=3)
    yield make("mixing", "4.3.4", ("R1", "R3"), _fan(eye, at, 0.85, ("mixing",), 16),
               [ball(mirror=0.4, T=0.5, n=1.3, color=(0.9, 0.7, 0.3)), FLOOR, *BALLS], background=sky, max_depth=4)
    hall = [_object("plane", (-2, 0, 0), a=1, b=0, c=0, mirror=0.8, color=(0.9, 0.5, 0.5)),
            _object("plane", (2, 0, 0), a=-1, b=0, c=0, mirror=0.8, color=(0.5, 0.9, 0.5))]
    for depth in (0, 1, 3):
        yield make(f"recursion-{depth}", "4.3", ("D1", "D2"), _fan((0, 0, -1), (1.5, 0, 1), 0.8, ("depth", "mirror"), 6), hall,
                   lights=[((0.5, 1, 1), (0.7, 0.7, 0.7))], background=sky, max_depth=depth)
    wall = lambda z, color: _object("plane", (0, 0, z), a=0, b=0, c=-1, color=color)
    red, green, blue = wall(3.02, (1, 0, 0)), wall(3.06, (0, 1, 0)), wall(3.06, (0, 0, 1))
    yellow = _object("sphere", (0, 0, 3.5), r=0.47, color=(1, 1, 0))
    front = [((0, 0, -1), (1, 1, 1))]
    yield make("order", "4.1", ("M4",), _fan((0.3, 0.2, 0), (0, 0, 3), 0.6, ("tie",), 8), [green, red, yellow],
               lights=front)
    yield make("order-at-one-distance", "4.1", ("M4",), _fan((0, 0, 0), (0, 0, 3), 0.6, ("tie",), 8), [green, blue],
               lights=front)
    yield make("nothing", "4.3", ("D2", "M5"), [*_fan(eye, (0, 5, 1), 1.0, ("background",), 4),
                                               ((0.0, 0.3, -29.5), (0.0, 0.0, 1.0), ("range",)),
                                               ((0.0, 0.3, -30.0), (0.0, 0.0, 1.0), ("range",))], [ball()], background=sky)


# --- as the figures, or the misprint, have it -------------------------------------------------------------------------------
def _switched() -> Iterator[Group]:
    eye, at = (0.0, 0.4, -4.0), (0.0, 0.3, 1.0)
    glass = _object("sphere", (0, 0.3, 1), r=0.9, T=0.8, mirror=0.1, n=1.4, color=(0.8, 0.9, 1))
    scene = [glass, FLOOR, *BALLS]
    lights = [LAMP, DIM, ((0, 6, 6), (0.6, 0.6, 0.6))]
    everything = [*_fan(eye, at, 0.85, ("switch", "entering"), 8),
                  *_fan((0, 3, -3), (0.3, -1, 2), 2.2, ("switch", "shadow"), 16)]
    for name, switch, tracing in (("misprint", "E1", {"refraction": "as_printed"}), ("balanced", "F1", {"lights": "balanced"}),
                                  ("ambient", "F2", {"ambient": 0.15}), ("opaque-only", "F3", {"shadows": "opaque_only"}),
                                  ("range-of-a-path", "F4", {"range": "path", "max_distance": 9.0}),
                                  ("as-in-the-figures", "F1", {"lights": "balanced", "ambient": 0.1, "shadows": "opaque_only",
                                                               "range": "path"})):
        decisions = ("F1", "F2", "F3", "F4") if name == "as-in-the-figures" else (switch,)
        yield Group(f"switches/{name}", _scene(f"vectors-{name}", scene, lights, background=(0.2, 0.3, 0.5), **tracing), "4.3",
                    decisions, (), _numbered(f"switches/{name}", everything))


# --- cameras (section 2, 5) -------------------------------------------------------------------------------------------------
def _cameras() -> Iterator[Group]:
    objects = [FLOOR, _object("sphere", (0.8, 0.7, 3), r=0.6, color=(0.9, 0.3, 0.1)),
               _object("torus", (-0.9, -0.2, 3.4), R=0.6, r=0.2, color=(0.2, 0.7, 0.4))]
    sky = (0.1, 0.2, 0.4)
    for name, decisions, camera, tracing in (
            ("landscape", ("C1",), {"width": 16, "height": 10, "fov": 70.0}, {}),
            ("portrait", ("C1",), {"width": 9, "height": 16, "fov": 70.0}, {}),
            ("turned", ("C1",), {"width": 14, "height": 9, "fov": 50.0, "position": (3.0, 1.5, 1.0),
                                 "direction": (-1.5, -0.7, 1.2), "up": (0.2, 2.0, 0.3)}, {}),
            ("samples", ("C2",), {"width": 10, "height": 8}, {"samples": 3}),
            ("oblique", ("F5",), {"width": 12, "height": 9, "direction": (0.0, -0.25, 0.97), "v_x": (1.0, 0.0, 0.0),
                                  "v_y": (0.0, 1.0, 0.0)}, {})):
        yield Group(f"pictures/{name}", _scene(f"vectors-{name}", objects, [LAMP], sky, camera, **tracing), "2",
                    decisions, ("camera",) + (("switch",) if decisions == ("F5",) else ()))
