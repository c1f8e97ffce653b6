"""Sections 2 to 5 once more, with 77 digits: whole paths of light for a few pixels, in python-flint's numbers.

Nothing here is shared with the fast tracer but the scene and the surfaces' f: no Dr.Jit, no tables, no boxes, no
floats. A ray's numbers are rounded to `BITS` bits, and what the rounded ray meets is decided exactly (line.py), so that
discrete decisions are free of rounding down to 1e-70.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field

from flint import arb, fmpq

from ..numbers.exact import Series, rational
from ..scene.model import Object, Rotation, Scene
from .line import Line, follow
from .records import NOTHING, PRIMARY, REFLECTION, REFRACTION
from .search import precision

BITS = 256  # of a root; rays and colours carry 64 more


Triple = tuple[arb, arb, arb]


class Critical(ArithmeticError):
    """A decision that 77 digits do not settle; the text says which."""


@dataclass(frozen=True)
class Decision:
    """What was decided about one ray of a path: what it met, and how much of each light reaches that point."""

    generation: int
    kind: int
    index: int  # the object, or NOTHING
    lights: tuple[float | None, ...]  # intensity of each light; None where no shadow ray was traced


@dataclass
class Path:
    """The light of one pixel and every decision on its way."""

    color: list[arb] = field(default_factory=lambda: [arb(0)] * 3)
    decisions: Counter = field(default_factory=Counter)
    rays: int = 0  # shadow rays included


def dot(a: Triple, b: Triple) -> arb:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def plus(a: Triple, b: Triple, factor=1) -> Triple:
    """a + factor b"""
    return tuple(p + factor * q for p, q in zip(a, b))


def unit(v: Triple) -> Triple:
    length = dot(v, v).sqrt()
    return tuple(c / length for c in v)


def cross(a: Triple, b: Triple) -> Triple:
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


def triple(v) -> Triple:
    return tuple(arb(rational(c)) for c in v)


def turned(rotation: Rotation | None) -> tuple[Triple, Triple, Triple] | None:
    """The images of the axes under `rotation` (Rodrigues' formula, decision O3)."""
    if rotation is None:
        return None
    k, turn = unit(triple(rotation.axis)), arb(rational(rotation.degrees)) / 180
    cos, sin = turn.cos_pi(), turn.sin_pi()
    axes = (triple(e) for e in ((1, 0, 0), (0, 1, 0), (0, 0, 1)))
    return tuple(plus(plus(tuple(cos * c for c in e), cross(k, e), sin), k, (1 - cos) * dot(k, e)) for e in axes)


class Body:
    """One object, met in its own frame."""

    def __init__(self, obj: Object):
        self.object, self.surface, self.material = obj, obj.surface, obj.material
        self.center, self.axes = triple(obj.surface.center), turned(obj.rotation)

    def _into(self, v: Triple) -> Triple:
        return v if self.axes is None else tuple(dot(axis, v) for axis in self.axes)

    def line(self, o: Triple, d: Triple, inside: bool, limit: arb, only_first: bool = False) -> Line:
        local = [[rational(c) for c in self._into(v)] for v in (plus(o, self.center, -1), d)]
        line = follow(self.surface, *local, inside, rational(limit), BITS, only_first)
        if line.undecided:
            raise Critical(line.undecided)
        return line

    def holds(self, point: Triple) -> bool:
        """Whether f < 0 at `point` (decision O1)."""
        p = self._into(plus(point, self.center, -1))
        return bool(self._along(p, triple((0, 0, 0))).s[0] < 0)

    def normal(self, point: Triple) -> Triple:
        """grad f / |grad f|, of the regular form (decision N1)."""
        p = self._into(plus(point, self.center, -1))
        slopes = [self._along(p, triple(e)).s[1] for e in ((1, 0, 0), (0, 1, 0), (0, 0, 1))]
        if self.axes:
            slopes = plus(plus(tuple(slopes[0] * c for c in self.axes[0]), self.axes[1], slopes[1]),
                          self.axes[2], slopes[2])
        normal = unit(slopes)
        if not all(c.is_finite() for c in normal):
            raise Critical("the gradient does not exist where a ray meets the surface")
        return normal

    def _along(self, point: Triple, direction: Triple) -> Series:
        """f at point + t direction, t = 0, with its derivatives in t."""
        parameters = {name: Series.constant(value) for name, value in self.surface.parameters.items()}
        value = self.surface.regular_form(*Series.along(point, direction, arb(0)), **parameters)
        return -value if self.surface.inside == "positive" else value


class PreciseTracer:
    """The tracer of the document for single pixels of `scene`."""

    def __init__(self, scene: Scene):
        self.scene = scene
        with precision(BITS + 64):
            self.bodies = [Body(obj) for obj in scene.objects]
            self.lights = [(triple(light.position), triple(light.brightness)) for light in scene.lights]
            self.limit = arb(rational(scene.tracing.max_distance))
            self._place_camera()

    def _place_camera(self):
        """Section 2, decisions C1 and F5."""
        camera = self.scene.camera
        self.v_pos, self.v_dir = triple(camera.position), unit(triple(camera.direction))
        self.v_x = unit(triple(camera.v_x) if camera.v_x else cross(triple(camera.up), self.v_dir))
        self.v_y = unit(triple(camera.v_y) if camera.v_y else cross(self.v_dir, self.v_x))
        half_angle = arb(rational(camera.fov)) / 360
        self.ratio = 2 * half_angle.sin_pi() / half_angle.cos_pi() / max(camera.width, camera.height)
        self.sides = tuple(body.holds(self.v_pos) for body in self.bodies)

    def pixel(self, row: int, col: int, nudge: float = 0.0) -> Path:
        """The light of a pixel, row 0 at the top (sections 2 and 5). Raises Critical.

        `nudge` turns every camera ray by about so many radians: it shows how firm the answer is.
        """
        camera, n = self.scene.camera, self.scene.tracing.samples
        with precision(BITS + 64):
            path, offset = Path(), arb(rational(nudge))
            for i in range(n):
                for j in range(n):
                    x = self.ratio * (col + fmpq(2 * j + 1, 2 * n) - fmpq(camera.width, 2)) + offset
                    y = self.ratio * (fmpq(camera.height, 2) - row - fmpq(2 * i + 1, 2 * n)) + offset / 2
                    d = unit(plus(plus(self.v_dir, self.v_x, x), self.v_y, y))
                    color = self._trace(path, self.v_pos, d, self.sides, self.limit, 0, PRIMARY)
                    path.color = [a + b / n**2 for a, b in zip(path.color, color)]
            return path

    def _trace(self, path: Path, o: Triple, d: Triple, sides, limit: arb, generation: int, kind: int) -> Triple:
        """The colour a ray of range `limit` brings back (section 4.3)."""
        if generation > self.scene.tracing.max_depth:  # decision D1
            return triple(self.scene.background)
        path.rays += 1
        t, index = self._first_hit(o, d, sides, limit)
        if index == NOTHING:
            path.decisions[Decision(generation, kind, NOTHING, ())] += 1
            return triple(self.scene.background)
        body, point = self.bodies[index], plus(o, d, t)
        if self.scene.tracing.range == "path":  # decision F4
            limit -= t
        normal = body.normal(point)
        if dot(d, normal) > 0:
            normal = tuple(-c for c in normal)
        cos1 = -dot(d, normal)
        m = body.material
        R, T = arb(rational(m.reflection)), arb(rational(m.transparency))
        color, lights = (arb(0),) * 3, (None,) * len(self.lights)
        if (1 - R) * (1 - T) > 0:
            illumination, lights = self._illumination(path, point, normal, sides)
            color = tuple((1 - R) * (1 - T) * arb(rational(c)) * i for c, i in zip(m.color, illumination))
        path.decisions[Decision(generation, kind, index, lights)] += 1
        follow = lambda kind, direction, sides: self._trace(path, point, unit(direction), sides, limit, generation + 1, kind)

        refracted = None
        if T > 0:  # section 4.3.3
            through = tuple(inside ^ (k == index) for k, inside in enumerate(sides))
            refracted = self._refraction(d, normal, cos1, arb(rational(m.refractive_index)), leaving=sides[index])
        shared = T if T > 0 and refracted is None else arb(0)  # total internal reflection (R3)
        weight = R * (1 - T) + shared
        if weight > 0:  # section 4.3.2
            color = plus(color, follow(REFLECTION, plus(d, normal, 2 * cos1), sides), weight)
        if refracted is not None:
            color = plus(color, follow(REFRACTION, refracted, through), T)
        return color

    def _first_hit(self, o, d, sides, limit: arb) -> tuple[arb | None, int]:
        """(t, object) of the first change of side within `limit`; index NOTHING where there is none."""
        best, index = None, NOTHING
        for k, body in enumerate(self.bodies):
            t = body.line(o, d, sides[k], limit, only_first=True).first
            if t is None:
                continue
            if best is not None and not t < best and not best < t:
                raise Critical("two surfaces at one distance")
            if best is None or t < best:
                best, index = t, k
        return best, index

    def _illumination(self, path: Path, point: Triple, normal: Triple, sides):
        """Section 4.3.1: the light that arrives, and the intensity of every light behind a shadow ray."""
        total, intensities = (arb(rational(self.scene.tracing.ambient)),) * 3, []  # decision F2
        for position, brightness in self.lights:
            to_light = plus(position, point, -1)
            distance, shadow_dir = dot(to_light, to_light).sqrt(), unit(to_light)
            cos = dot(shadow_dir, normal)
            if not cos > 0:  # decision L2
                intensities.append(None)
                continue
            path.rays += 1
            intensity = arb(1)
            for body, inside in zip(self.bodies, sides):
                if not self.scene.casts_shadow(body.object):
                    continue
                T = arb(rational(body.material.transparency))
                crossed = len(body.line(point, shadow_dir, inside, distance, only_first=not T > 0).crossings)
                intensity *= T**crossed  # L3; 0**0 is 1
            intensities.append(round(float(intensity), 12))
            light = tuple(cos * intensity * b for b in brightness)
            if self.scene.tracing.lights == "balanced":  # decision F1
                total = tuple(1 - (1 - sum_) * (1 - one) for sum_, one in zip(total, light))
            else:
                total = plus(total, light)
        return total, tuple(intensities)

    def _refraction(self, d, normal, cos1: arb, n: arb, leaving: bool) -> Triple | None:
        """The direction of the refraction ray; None where there is total internal reflection (R1, R2, E1)."""
        n1, n2 = (n, arb(1)) if leaving else (arb(1), n)
        sin1 = (1 - cos1 * cos1).nonnegative_part().sqrt()
        if sin1 > n2 / n1:
            return None
        sin2 = sin1 * (n2 / n1 if self.scene.tracing.refraction == "as_printed" else n1 / n2)
        cos2 = (1 - sin2 * sin2).nonnegative_part().sqrt()
        return plus(tuple(c * n1 / n2 for c in plus(d, normal, cos1)), normal, -cos2)
