"""Random scenes of one object, sometimes two: one seed, one scene.

A solid is drawn from `SOLIDS`, written out, and changed: a factor, a power, another factor that is zero elsewhere, an
offset or a scale of the coordinates inside of the formula. Where it stands, how it is turned, seen and lit is drawn too.
Every solid is known to lie within a cube about its centre, so that `bounds` are true. SHARED seeds in a row draw the same
formula, whose kernels are compiled once, and everything else anew.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from dataclasses import dataclass, field
from random import Random

from flint import fmpq_mpoly_ctx

from .arithmetic import rational

WIDTH, HEIGHT = 12, 9
MOST_TURNS = 720
SHARED = 8
SWITCHED = 0.08  # of the scenes, each of five switches


@dataclass
class Drawn:
    """A scene as its file has it, and what it is made of."""

    seed: int
    kind: str  # of formula: its class in reports
    scene: dict
    traits: set[str] = field(default_factory=set)


@dataclass
class Shape:
    """A formula in x, y, z, negative inside, with its surface within the cube of half side `size` (None: unbounded)."""

    text: str
    size: float | None


def draw(seed: int) -> Drawn:
    """The scene of one seed."""
    return _Draw(seed).scene()


class _Draw:
    def __init__(self, seed: int):
        self.seed, self.random, self.traits = seed, Random(f"formula {seed // SHARED}"), set()

    # --- numbers ---------------------------------------------------------------------------------------------------
    def chance(self, p: float) -> bool:
        return self.random.random() < p

    def between(self, low: float, high: float) -> float:
        """A number of three digits, as people type them, or one of all digits."""
        value = self.random.uniform(low, high)
        return value if self.chance(0.2) else float(f"{value:.3g}")

    def size_between(self, low: float, high: float) -> float:
        """A size, uniform in its logarithm."""
        return float(f"{math.exp(self.random.uniform(math.log(low), math.log(high))):.4g}")

    def direction(self) -> list[float]:
        while True:
            v = [self.random.gauss(0, 1) for _ in range(3)]
            if math.hypot(*v) > 0.1:
                return [c / math.hypot(*v) for c in v]

    # --- the scene -------------------------------------------------------------------------------------------------
    def scene(self) -> Drawn:
        kind = self.random.choice(list(SOLIDS))
        shape = self.random.choice(SOLIDS[kind])(self)
        if isinstance(shape, dict):  # a surface of raytruth's own
            surface, size, scale = shape, shape.pop("size"), 1.0
        else:
            surface, size, scale = self._written(shape)
        positive, turned, paired, optics = self.chance(0.1), self.chance(0.3), self.chance(0.12), self.random.random()
        light_count = self.random.choice((1, 1, 2))
        self.random = Random(f"scene {self.seed}")  # what follows changes no kernel
        far = self.chance(0.15)
        if far:
            self.traits.add("translated")
            surface["center"] = [self.between(-1e4, 1e4) for _ in range(3)]
        elif self.chance(0.7):
            surface["center"] = [scale * self.between(-2, 2) for _ in range(3)]
        if positive:
            self.traits.add("inside positive")
            surface["inside"] = "positive"
        thing = {"surface": surface, "material": self._material(optics)}
        if turned:
            self.traits.add("rotated")
            thing["rotation"] = {"axis": self.direction(),
                                 "degrees": self.random.choice((90.0, 180.0, self.between(0, MOST_TURNS)))}
        objects = [thing]
        if paired and thing["material"].get("transparency", 0) == 0:
            kind = "pairs"
            objects.append(self._twin(thing, scale))
            if self.chance(0.5):
                objects.reverse()
        camera, away = self._camera(surface, self._offset if scale == 1 else (0, 0, 0), size, scale)
        lights = [{"position": self._beside(surface, size, self.random.uniform(2, 6)),
                   "brightness": [self.between(0.2, 1) for _ in range(3)]} for _ in range(light_count)]
        longest = min(max(20 * size, 3 * away), 1e6)
        tracing = {"max_distance": longest, "step_size": max(longest / 3000, 1e-6),
                   "max_depth": self.random.choice((1, 1, 2))}
        scene = {"name": f"random-{self.seed}", "camera": camera, "objects": objects, "lights": lights,
                 "background": [self.between(0, 0.5) for _ in range(3)], "tracing": tracing}
        self._switch(scene)
        return Drawn(self.seed, kind, scene, self.traits)

    def _switch(self, scene: dict) -> None:
        """Decisions F1 to F5, each on some scenes; SHARED seeds in a row share them as they share kernels."""
        random, tracing, camera = Random(f"switches {self.seed // SHARED}"), scene["tracing"], scene["camera"]
        chosen = [random.random() < SWITCHED for _ in range(5)]
        usual = ({"lights": "balanced"}, {"ambient": self.between(0.05, 0.5)}, {"shadows": "opaque_only"}, {"range": "path"})
        for on, switch in zip(chosen, usual):
            tracing |= switch if on else {}
        if chosen[4]:
            sheared = lambda axis: [c + self.between(-0.2, 0.2) for c in axis]
            (a, b, c), (p, q, r) = camera["up"], camera["direction"]
            camera |= {"v_x": sheared((b * r - c * q, c * p - a * r, a * q - b * p)), "v_y": sheared(camera["up"])}
        self.traits |= {"switches"} if any(chosen) else set()

    _offset = (0.0, 0.0, 0.0)

    def _written(self, shape: Shape) -> tuple[dict, float, float]:
        """The shape as a surface, its size, and the scale of its coordinates."""
        text, bounded = shape.text, shape.size is not None
        size = shape.size or 2.0
        if self.chance(0.12):
            text = self._powered(text)
        elif self.chance(0.1):
            text = self._multiplied(text, size)
        scale = 1.0
        if self.chance(0.12):
            scale = self.size_between(1e-6, 3e4)
            self.traits.add("scaled")
            text = _with(text, lambda v: f"({v}/{scale!r})")
        elif self.chance(0.1):
            self.traits.add("offset")
            largest = self.random.choice((1.0, 10.0, 1e3, 1e4))
            self._offset = tuple(self.between(-largest, largest) for _ in range(3))
            text = _with(text, lambda v: f"({v}-({self._offset['xyz'.index(v)]!r}))")
        if self.chance(0.25):
            text = self._times_a_factor(text)
        surface = {"type": "expression", "formula": text}
        size *= scale
        if bounded and self.chance(0.5):
            self.traits.add("bounds")
            margin = self.random.choice((1.0625, 1.25, 2.0))
            low = [o - size * margin for o in self._offset]
            surface["bounds"] = {"low": low, "high": [o + size * margin for o in self._offset]}
        return surface, size, scale

    def _powered(self, text: str) -> str:
        n = self.random.choice((2, 3, 3, 4, 5, 5, 6, 7))
        self.traits.add(f"power {n}")
        return f"({text})**{n}"

    def _multiplied(self, text: str, size: float) -> str:
        """Times something with a sign of its own, or with none."""
        self.traits.add("product")
        c = [self.between(-0.5 * size, 0.5 * size) for _ in range(3)]
        ball = f"(x-({c[0]!r}))**2+(y-({c[1]!r}))**2+(z-({c[2]!r}))**2"
        r = self.between(0.2, 0.4) * size
        return self.random.choice((
            f"({text})*(x*x+y*y+z*z+{self.between(0.1, 2)!r})",
            f"({text})*({ball}-{r * r!r})",
            f"({text})*({ball}-{r * r!r})**2",
            f"({text})**3*({ball}-{r * r!r})"))

    def _times_a_factor(self, text: str) -> str:
        self.traits.add("factor")
        exponent = self.random.choice((self.random.uniform(-20, 20), self.random.uniform(-300, 300)))
        factor = f"{self.random.uniform(1, 9):.2f}e{int(exponent)}"
        return f"{factor}*({text})"

    def _twin(self, thing: dict, scale: float) -> dict:
        """The same object again, moved by next to nothing, or grown."""
        gap = self.random.choice((0.0, 1e-16, 1e-15, 1e-14, 1e-13, 1e-12, 1e-11, 1e-10, 1e-9))
        self.traits.add(f"gap {gap:g}")
        surface = dict(thing["surface"])
        center = list(surface.get("center", (0.0, 0.0, 0.0)))
        center[self.random.randrange(3)] += gap * scale
        surface["center"] = center
        return {**thing, "surface": surface, "material": {**thing["material"], "color": [1.0, 0.0, 0.0]}}

    def _material(self, optics: float) -> dict:
        """Of every ten materials six are dull, two mirrors, two glass, a part of it both."""
        material = {"color": [self.between(0.2, 1) for _ in range(3)]}
        if optics > 0.6:
            self.traits.add("secondary rays")
        if 0.6 < optics < 0.8 or optics > 0.95:
            material["reflection"] = self.between(0.1, 0.9)
        if optics > 0.8:
            material["transparency"] = self.between(0.1, 0.9)
            material["refractive_index"] = self.random.choice((1.0, 1.5, self.between(1.01, 2.5), self.between(0.5, 0.99)))
        return material

    def _camera(self, surface: dict, offset, size: float, scale: float) -> tuple[dict, float]:
        """A camera that sees the surface from near, far, within, or along an axis; and its distance."""
        center = [c + o for c, o in zip(surface.get("center", (0.0, 0.0, 0.0)), offset)]
        place, aligned = self.random.random(), self.chance(0.08)
        away = size * (self.random.uniform(2, 4) if place < 0.7 else self.random.uniform(20, 300) if place < 0.85
                       else self.random.uniform(0.1, 0.9))
        away = min(away, 3e5)
        self.traits |= {"far"} if 0.7 <= place < 0.85 else {"within"} if place >= 0.85 else set()
        if aligned:
            self.traits.add("aligned")
            direction = [0.0, 0.0, 0.0]
            direction[self.random.randrange(3)] = self.random.choice((-1.0, 1.0))
            aim = center
        else:
            direction = self.direction()
            aim = [c + 0.3 * size * self.random.uniform(-1, 1) for c in center]
        position = [a - away * d for a, d in zip(aim, direction)]
        wide = math.degrees(2 * math.atan(1.2 * size / away))
        up = self.random.choice(([0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]))
        if abs(sum(a * b for a, b in zip(up, direction))) > 0.95:
            up = up[1:] + up[:1]
        odd = aligned and self.chance(0.7)
        return {"position": position, "direction": direction, "up": up, "fov": min(max(wide, 0.1), 110.0),
                "width": WIDTH + odd, "height": HEIGHT}, away

    def _beside(self, surface: dict, size: float, times: float) -> list[float]:
        return [c + o + times * size * d for c, o, d in
                zip(surface.get("center", (0.0, 0.0, 0.0)), self._offset, self.direction())]

    # --- solids ----------------------------------------------------------------------------------------------------
    def ball(self):
        r = self.between(0.5, 1.5)
        return Shape(self.random.choice((f"x**2+y**2+z**2-{r * r!r}", f"x*x+y*y+z*z-{r!r}**2",
                                         f"(x*x+y*y+z*z)/{r * r!r}-1", f"{r * r!r}-(0-x*x-y*y-z*z)-{2 * r * r!r}")), r)

    def ellipsoid(self):
        a, b, c = (self.between(0.3, 1.5) for _ in range(3))
        return Shape(f"x**2/{a * a!r}+y**2/{b * b!r}+z**2/{c * c!r}-1", max(a, b, c))

    def even(self):
        p, q, r = (self.random.choice((2, 4, 6, 8)) for _ in range(3))
        return Shape(f"x**{p}+y**{q}+z**{r}-{self.between(0.5, 1)!r}", 1.0)

    def quartic_torus(self):
        R, r = self.between(0.7, 1.2), self.between(0.1, 0.5)
        return Shape(f"(x*x+y*y+z*z+{R * R - r * r!r})**2-{4 * R * R!r}*(x*x+y*y)", R + r)

    def tanglecube(self):
        return Shape(f"x**4-5*x**2+y**4-5*y**2+z**4-5*z**2+{self.between(11.3, 12.5)!r}", 2.6)

    def goursat(self):
        a, b = self.between(-0.4, 0.3), self.between(-1.0, 0.5)
        return Shape(f"x**4+y**4+z**4+({a!r})*(x*x+y*y+z*z)**2+({b!r})*(x*x+y*y+z*z)-1", 3.0 if a > -0.25 else None)

    def decocube(self):
        c = self.between(0.3, 0.5)
        return Shape(f"((x*x+y*y-{c!r})**2+(z*z-1)**2)*((y*y+z*z-{c!r})**2+(x*x-1)**2)*((z*z+x*x-{c!r})**2+(y*y-1)**2)"
                     f"-{self.between(0.01, 0.05)!r}", 1.6)

    def heart(self):
        a = self.between(2, 2.5)
        return Shape(f"(x**2+{a!r}*y**2+z**2-1)**3-x**2*z**3-0.1125*y**2*z**3", 1.5)

    def cayley(self):
        return Shape(f"x**2+y**2+z**2+{self.between(1.5, 2.5)!r}*x*y*z-1", None)

    def clebsch(self):
        c = self.between(0.5, 1)
        return Shape(f"x**3+y**3+z**3+{c!r}**3-(x+y+z+{c!r})**3", None)

    def kummer(self):
        m = self.between(1.1, 1.6)
        k = (3 * m - 1) / (3 - m)
        s = repr(2**0.5)
        return Shape(f"(x*x+y*y+z*z-{m!r})**2-({k!r})*(1-z-{s}*x)*(1-z+{s}*x)*(1+z+{s}*y)*(1+z-{s}*y)", None)

    def barth(self):
        p = repr((1 + 5**0.5) / 2)
        return Shape(f"4*({p}**2*x**2-y**2)*({p}**2*y**2-z**2)*({p}**2*z**2-x**2)-(1+2*{p})*(x**2+y**2+z**2-1)**2", None)

    def expanded(self):
        """A product of quadrics about another origin, multiplied out."""
        ring = fmpq_mpoly_ctx.get(("x", "y", "z"))
        x, y, z = ring.gens()
        product, shift = 1, [rational(self.between(-1, 1)) for _ in range(3)]
        for _ in range(self.random.choice((1, 2))):
            a, b, c = (rational(self.between(0.5, 2)) for _ in range(3))
            product = product * (a * (x - shift[0]) ** 2 + b * (y - shift[1]) ** 2 + c * (z - shift[2]) ** 2
                                 - rational(self.between(0.2, 1)))
        terms = []
        for powers, coefficient in product.to_dict().items():
            names = [v if n == 1 else f"{v}**{int(n)}" for v, n in zip("xyz", powers) if n]
            terms.append("*".join([f"({float(coefficient.p) / float(coefficient.q)!r})", *names]))
        return Shape("+".join(terms), 2.5)

    def superellipsoid(self):
        p, q, r = (self.between(0.5, 6) for _ in range(3))
        if self.chance(0.3):
            return Shape(f"(abs(x)**{p!r}+abs(y)**{p!r})**{q / p!r}+abs(z)**{q!r}-1", 1.0)
        return Shape(f"abs(x)**{p!r}+abs(y)**{q!r}+abs(z)**{r!r}-1", 1.0)

    def squares_to_a_power(self):
        p, q, r = (self.between(0.3, 3) for _ in range(3))
        return Shape(f"(x*x)**{p!r}+(y*y)**{q!r}+(z*z)**{r!r}-1", 1.0)

    def power_of_radius(self):
        return Shape(f"(x*x+y*y+z*z)**{self.between(0.3, 3)!r}-{self.between(0.5, 1)!r}", 1.0)

    def torus(self):
        R, r = self.between(0.7, 1.2), self.between(0.1, 0.5)
        return Shape(f"(sqrt(x**2+y**2)-{R!r})**2+z**2-{r * r!r}", R + r)

    def distance(self):
        return Shape(f"sqrt(x*x+y*y+z*z)-{self.between(0.5, 1)!r}", 1.0)

    def capsule(self):
        return Shape(f"sqrt(x*x+y*y+max(abs(z)-0.5,0)**2)-{self.between(0.3, 1)!r}", 1.5)

    def cubic_roots(self):
        return Shape(f"cbrt(x*x)+cbrt(y*y)+cbrt(z*z)-{self.between(0.6, 1)!r}" if self.chance(0.5) else
                     f"x*x+y*y+cbrt(z)**2-{self.between(0.6, 1)!r}", 1.0)

    def gaussians(self):
        a, s = self.between(0.5, 1.2), self.between(1, 4)
        return Shape(f"{self.between(0.3, 0.7)!r}-exp(-{s!r}*((x-{a!r})**2+y*y+z*z))"
                     f"-exp(-{s!r}*((x+{a!r})**2+y*y+z*z))", 3.0)

    def logarithm(self):
        return Shape(f"log(1+x*x+{self.between(0.5, 2)!r}*y*y+z*z)-{self.between(0.3, 0.6)!r}", 1.5)

    def log_of_radius(self):
        return Shape(f"log(x*x+y*y+z*z)+{self.between(-0.5, 0.5)!r}", 1.4)

    def hyperbolic(self):
        return Shape(f"exp(x)+exp(-x)+exp(y)+exp(-y)+exp(z)+exp(-z)-{self.between(6.5, 9)!r}", 2.0)

    def gyroid(self):
        k, r = self.between(2, 5), self.between(0.8, 1.5)
        return Shape(f"max(sin({k!r}*x)*cos({k!r}*y)+sin({k!r}*y)*cos({k!r}*z)+sin({k!r}*z)*cos({k!r}*x),"
                     f"x*x+y*y+z*z-{r * r!r})", r)

    def bumps(self):
        k = self.between(2, 8)
        return Shape(f"x*x+y*y+z*z-1+{self.between(0.02, 0.2)!r}*sin({k!r}*x)*sin({k!r}*y)*cos({k!r}*z)", 1.2)

    def waves(self):
        k = self.between(1, 4)
        return Shape(f"z-{self.between(0.1, 0.4)!r}*cos({k!r}*x)*sin({k!r}*y)", None)

    def gyroid_shell(self):
        k = self.between(1, 3)
        return Shape(f"abs(sin({k!r}*x)*cos({k!r}*y)+sin({k!r}*y)*cos({k!r}*z)+sin({k!r}*z)*cos({k!r}*x))"
                     f"-{self.between(0.05, 0.3)!r}", None)

    def hemisphere(self):
        r = self.between(0.5, 1.2)
        return Shape(self.random.choice((f"max(x*x+y*y+z*z-{r * r!r},z)", f"max(x*x+y*y+z*z-{r * r!r},-z)")), r)

    def cone(self):
        h = self.between(0.6, 1)
        return Shape(self.random.choice((f"max(x*x+y*y-z*z,abs(z)-{h!r})", f"max(sqrt(x*x+y*y)-{h!r}+z,0-z)")), 1.0)

    def octahedron(self):
        return Shape(f"abs(x)+abs(y)+abs(z)-{self.between(0.6, 1.2)!r}", 1.2)

    def cube(self):
        return Shape(f"max(max(abs(x),abs(y)),abs(z))-{self.between(0.5, 1)!r}", 1.0)

    def union(self):
        a, r = self.between(0.3, 0.9), self.between(0.5, 0.9)
        word = self.random.choice(("min", "max"))
        return Shape(f"{word}((x-{a!r})**2+y*y+z*z-{r!r},(x+{a!r})**2+y*y+z*z-{r!r})", 2.0)

    def reuleaux(self):
        a, r = self.between(0.2, 0.4), self.between(0.9, 1.2)
        return Shape(f"max(max((x-{a!r})**2+y*y+z*z-{r!r},(x+{a!r})**2+y*y+z*z-{r!r}),"
                     f"max(x*x+(y-{a!r})**2+z*z-{r!r},x*x+(y+{a!r})**2+z*z-{r!r}))", 1.2)

    def root_of_a_difference(self):
        r = self.between(0.8, 1.2)
        return Shape(self.random.choice((f"z-sqrt({r * r!r}-x*x-y*y)", f"max(z-sqrt({r * r!r}-x*x-y*y),-z)")), r)

    def log_of_x(self):
        return Shape(f"log(x+{self.between(0.5, 1)!r})+y*y+z*z-{self.between(0.1, 0.5)!r}", None)

    def power_of_x(self):
        return Shape(f"(x+{self.between(0.3, 1)!r})**{self.between(0.5, 3)!r}+y*y+z*z-{self.between(0.5, 1)!r}", None)

    def own(self):
        """A surface with a type of its own."""
        r = lambda: self.between(0.3, 1.2)
        return self.random.choice((
            lambda: {"type": "sphere", "r": r(), "size": 1.2},
            lambda: {"type": "ellipsoid", "a": r(), "b": r(), "c": r(), "size": 1.2},
            lambda: {"type": "torus", "R": self.between(0.7, 1.0), "r": self.between(0.1, 0.5), "size": 1.5},
            lambda: {"type": "plane", "a": self.between(-1, 1), "b": self.between(-1, 1), "c": self.between(0.2, 1),
                     "size": 2.0},
            lambda: {"type": "paraboloid", "a": r(), "b": r(), "size": 2.0}))()


SOLIDS: dict[str, list[Callable[[_Draw], Shape | dict]]] = {
    "quadrics": [_Draw.ball, _Draw.ellipsoid],
    "own types": [_Draw.own],
    "polynomials": [_Draw.even, _Draw.quartic_torus, _Draw.tanglecube, _Draw.goursat, _Draw.heart, _Draw.decocube],
    "singular polynomials": [_Draw.cayley, _Draw.clebsch, _Draw.kummer, _Draw.barth],
    "expanded polynomials": [_Draw.expanded],
    "real exponents": [_Draw.superellipsoid, _Draw.squares_to_a_power, _Draw.power_of_radius],
    "roots": [_Draw.torus, _Draw.distance, _Draw.capsule, _Draw.cubic_roots],
    "exp and log": [_Draw.gaussians, _Draw.logarithm, _Draw.log_of_radius, _Draw.hyperbolic],
    "sines": [_Draw.gyroid, _Draw.bumps, _Draw.waves, _Draw.gyroid_shell],
    "creases": [_Draw.hemisphere, _Draw.cone, _Draw.octahedron, _Draw.cube, _Draw.union, _Draw.reuleaux],
    "not defined everywhere": [_Draw.root_of_a_difference, _Draw.log_of_x, _Draw.power_of_x]}


def _with(text: str, write: Callable[[str], str]) -> str:
    """The formula with every coordinate written otherwise."""
    return re.sub(r"\b[xyz]\b", lambda found: write(found[0]), text)
