"""What is right: the light of single pixels with more than 50 digits, from the text of a scene.

Nothing here comes from reference_tracer: the scene is a dictionary as its file has it, formulas are evaluated by
arithmetic.py, roots are isolated by FLINT or by subdivision of the ray. A hit is a change of sign (decision M1), the side
of a ray is inherited (M3); the light is that of section 4.3. Whatever cannot be told raises Unsettled with the reason.
"""

from __future__ import annotations

from contextlib import contextmanager
from dataclasses import dataclass

from flint import arb, ctx, fmpq, fmpq_poly

from .arithmetic import Formula, Taylor, Undefined, rational

BITS = 200  # of every number, about 60 digits
LEFT = fmpq(1, 10**25)  # within this share of a ray's range of its origin lies the surface that it leaves
APART = fmpq(1, 10**35)  # two distances closer than this share are one
MOST_PIECES = 3000  # of one ray
CLEAR = fmpq(1, 10**9)  # of its range, how far crossings have to be from a sample of the literal method
NARROWEST = fmpq(1, 10**30)  # share of a ray that is not divided further
UNIT = arb(0, 1)
NOTHING = -1

BUILT_IN = {"sphere": "x**2 + y**2 + z**2 - {r}**2",
            "ellipsoid": "x**2/{a}**2 + y**2/{b}**2 + z**2/{c}**2 - 1",
            "torus": "(sqrt(x**2 + y**2) - {R})**2 + z**2 - {r}**2",
            "plane": "{a}*x + {b}*y + {c}*z",
            "paraboloid": "x**2/{a}**2 + y**2/{b}**2 - z"}


class Unsettled(ArithmeticError):
    """The oracle cannot tell; the text says why."""


class NotDefined(Unsettled):
    """f certainly has no value somewhere on the way (decision M7)."""


@contextmanager
def precision(bits: int = BITS):
    """flint's working precision, restored afterwards: others in this process have their own."""
    with ctx.workprec(bits):
        yield


Triple = tuple


def dot(a: Triple, b: Triple):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def cross(a: Triple, b: Triple) -> Triple:
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


def along(a: Triple, b: Triple, factor=1) -> Triple:
    """a + factor b"""
    return tuple(p + factor * q for p, q in zip(a, b))


def unit(v: Triple) -> Triple:
    length = dot(v, v).sqrt()
    return tuple(c / length for c in v)


def balls(v) -> Triple:
    return tuple(arb(rational(c)) for c in v)


def points(v) -> Triple:
    """The middles of three balls, as rational numbers."""
    if not all(c.is_finite() for c in v if isinstance(c, arb)):
        raise Unsettled("a ray without a certain direction")
    return tuple(rational(c) for c in v)


class Solid:
    """One object of a scene."""

    def __init__(self, document: dict):
        surface = document["surface"]
        self.sign = -1 if surface.get("inside") == "positive" else 1
        text = surface["formula"] if surface["type"] == "expression" else _built_in(surface)
        self.formula = Formula(text)
        self.center = balls(surface.get("center", (0, 0, 0)))
        self.axes = _turned(document.get("rotation"))
        # what is promised to hold the surface counts where f may have no value outside; inside it, f is what it is
        self.box = surface.get("bounds") if self.sign > 0 and not self.formula.is_polynomial else None
        self.casts_shadow, material = document.get("shadow", True), document.get("material", {})
        self.color = balls(material.get("color", (1, 1, 1)))
        self.reflection, self.transparency, self.index = (
            arb(rational(material.get(name, usual))) for name, usual in
            (("reflection", 0), ("transparency", 0), ("refractive_index", 1)))

    def into(self, point: Triple, is_direction: bool = False) -> Triple:
        """A point or a direction in the object's own frame, as rational numbers."""
        v = balls(point) if is_direction else along(balls(point), self.center, -1)
        return points(v if self.axes is None else tuple(dot(axis, v) for axis in self.axes))

    def value(self, point: Triple) -> arb:
        """f, signed so that it is negative inside, at a point of the world."""
        return self.sign * self.along(self.into(point), (0, 0, 0), arb(0)).value

    def normal(self, point: Triple) -> Triple:
        """grad f, normalised, in the world."""
        slopes = self.gradient(self.into(point))
        if not all(s.is_finite() for s in slopes) or not dot(slopes, slopes) > 0:
            raise Unsettled("no gradient there")
        slopes = unit(slopes)
        if self.axes is None:
            return slopes
        return along(along(tuple(slopes[0] * c for c in self.axes[0]), self.axes[1], slopes[1]), self.axes[2], slopes[2])

    def gradient(self, local: Triple) -> Triple:
        """grad f, signed, at a point (rational numbers or balls) of the own frame."""
        return tuple(self.sign * self.along(local, e, arb(0)).slope for e in ((1, 0, 0), (0, 1, 0), (0, 0, 1)))

    def along(self, o: Triple, d: Triple, t: arb, odd_part: bool = False) -> Taylor:
        """f, not signed, or its odd part along a ray in the own frame, about the ball t."""
        try:
            slope = tuple(map(arb, d))
            return self.formula.taylor([arb(a) + b * t for a, b in zip(o, slope)], slope, odd_part)
        except Undefined as error:
            raise NotDefined(f"f is not defined on the ray: {error}") from None

    def crossings(self, o: Triple, d: Triple, limit: fmpq, inside: bool, leaves: bool, only_first: bool = False) -> list[arb]:
        """Where the ray o + t d, 0 < t < limit, of rational numbers changes side, in order.

        `inside` is the side it starts on; `leaves` tells that it starts on this very surface. Raises Unsettled.
        """
        o, d = self.into(o), self.into(d, is_direction=True)
        start = LEFT * limit if leaves else fmpq(0)
        if self.formula.is_polynomial:
            g = self.sign * self.formula.polynomial(*(fmpq_poly([a, b]) for a, b in zip(o, d)))
            if g(start) == 0 or g(limit) == 0:
                raise Unsettled("the ray starts or ends on the surface")
            if (g(start) < 0) != inside:
                raise Unsettled("the ray starts on the other side")
            return _odd_roots(g, start, limit)
        if self.box and not inside and not leaves:
            start, limit = self._within_box(o, d, start, limit)
            if start >= limit:
                return []
        return _Search(self, o, d).crossings(start, limit, inside, only_first)

    def is_far(self, point: Triple) -> bool:
        """Whether a point of the world lies outside of the bounds, where they count."""
        return bool(self.box) and any(not rational(float(low)) <= c <= rational(float(high)) for c, low, high in
                                      zip(self.into(point), self.box["low"], self.box["high"]))

    def _within_box(self, o: Triple, d: Triple, start: fmpq, limit: fmpq) -> tuple[fmpq, fmpq]:
        """The part of the ray within the bounds; start > limit where it passes by."""
        for a, b, low, high in zip(o, d, self.box["low"], self.box["high"]):
            low, high = rational(float(low)), rational(float(high))
            if b == 0:
                if not low <= a <= high:
                    return limit, start
                continue
            near, far = sorted(((low - a) / b, (high - a) / b))
            start, limit = max(start, near), min(limit, far)
        return start, limit


def _built_in(surface: dict) -> str:
    return BUILT_IN[surface["type"]].format(**{k: repr(float(v)) for k, v in surface.items() if isinstance(v, (int, float))})


def _turned(rotation: dict | None) -> tuple[Triple, Triple, Triple] | None:
    """The images of the axes (Rodrigues' formula)."""
    if rotation is None:
        return None
    k, turn = unit(balls(rotation["axis"])), arb(rational(rotation["degrees"])) / 180
    cos, sin = turn.cos_pi(), turn.sin_pi()
    return tuple(along(along(tuple(cos * c for c in e), cross(k, e), sin), k, (1 - cos) * dot(k, e))
                 for e in (balls(axis) for axis in ((1, 0, 0), (0, 1, 0), (0, 0, 1))))


def _odd_roots(g: fmpq_poly, start: fmpq, limit: fmpq) -> list[arb]:
    """The roots of odd multiplicity between start and limit, ascending; FLINT isolates those of squarefree factors."""
    roots = []
    for factor, multiplicity in (g.numer().factor_squarefree()[1] if g.degree() > 0 else []):
        if multiplicity % 2:
            roots += [r.real for r, _ in factor.complex_roots() if r.imag == 0]
    roots.sort(key=lambda r: r.mid().fmpq())
    found = [r for r in roots if r > arb(start) and r < arb(limit)]
    if any(r.contains(start) or r.contains(limit) for r in roots):
        raise Unsettled("a crossing where the ray starts or ends")
    return found


class _Search:
    """The crossings of one ray with a surface that is no polynomial: pieces of it, from the front, halved until g has
    provably no zero there or is monotone."""

    def __init__(self, solid: Solid, o: Triple, d: Triple):
        self.solid, self.o, self.d = solid, o, d

    def crossings(self, start: fmpq, limit: fmpq, inside: bool, only_first: bool) -> list[arb]:
        negative = self._is_negative(start)
        if negative != inside:
            raise Unsettled("the ray starts on the other side")
        found, rest, pieces = [], [(start, limit, self._is_negative_or_undefined(limit))], 0
        while rest and not (only_first and found):
            low, high, negative_at_high = rest.pop()
            pieces += 1
            if self._is_clear(low, high):
                if negative_at_high is None:
                    raise NotDefined("f is not defined where the piece ends")
                if negative_at_high != negative:
                    found.append(self._root(low, high, negative_at_high))
                    negative = negative_at_high
                continue
            if pieces > MOST_PIECES or high - low < NARROWEST * limit:
                raise Unsettled("the ray touches the surface")
            middle, sign = self._split(low, high)
            rest += [(middle, high, negative_at_high), (low, middle, sign)]
        return found

    def _at(self, t: arb):
        g = self.solid.along(self.o, self.d, t, odd_part=True)
        return tuple(self.solid.sign * c for c in (g.value, g.slope, g.half_curvature))

    def _is_clear(self, low: fmpq, high: fmpq) -> bool:
        """Whether g has no zero in [low, high] or g' has none: by enclosures, or by Taylor's about the middle."""
        middle, offset = arb((low + high) / 2), UNIT * arb((high - low) / 2)
        g, slope, half_curvature = self._at(middle + offset)
        if _is_signed(g) or _is_signed(slope):
            return True
        if not half_curvature.is_finite():
            return False
        g0, slope0, _ = self._at(middle)
        return _is_signed(g0 + slope * offset) or _is_signed(slope0 + 2 * half_curvature * offset)

    def _split(self, low: fmpq, high: fmpq) -> tuple[fmpq, bool | None]:
        """A point near the middle, and whether g is negative there; None where it is not defined."""
        for share in (fmpq(1, 2), fmpq(15, 32), fmpq(19, 32), fmpq(13, 32)):
            middle = low + (high - low) * share
            try:
                return middle, self._is_negative(middle)
            except NotDefined:
                return middle, None
            except Unsettled as error:
                reason = error
        raise reason

    def _is_negative(self, t: fmpq) -> bool:
        for bits in (BITS, 4 * BITS, 16 * BITS):
            with precision(bits):
                g = self._at(arb(t))[0]
            if _is_signed(g):
                return bool(g < 0)
        raise Unsettled("f is zero at a point of the ray")

    def _is_negative_or_undefined(self, t: fmpq) -> bool | None:
        try:
            return self._is_negative(t)
        except NotDefined:
            return None

    def _root(self, low: fmpq, high: fmpq, negative_at_high: bool) -> arb:
        """The one crossing in [low, high], where g is monotone: interval Newton, bisection where it does not help."""
        goal = high / (1 << (BITS - 40))
        while high - low > goal:
            x = (low + high) / 2
            newton = arb(x) - self._at(arb(x))[0] / self._at(arb(low).union(arb(high)))[1]
            if newton.is_finite() and newton.rad() < arb((high - low) / 5):
                low, high = max(low, newton.lower().fmpq()), min(high, newton.upper().fmpq())
            else:
                try:
                    low, high = (low, x) if self._is_negative(x) == negative_at_high else (x, high)
                except Unsettled:
                    return arb(x)
        return arb(low).union(arb(high))


def _is_signed(g: arb) -> bool:
    return g.is_finite() and not g.contains(0)


@dataclass
class Ray:
    """o + t d with rational numbers, |d| = 1 up to 1e-60, and the solids it is inside of."""

    o: Triple
    d: Triple
    inside: tuple[bool, ...]
    limit: fmpq  # how far it reaches
    leaves: int = NOTHING  # the object whose surface it starts on


@dataclass
class Hit:
    """What a ray meets first."""

    index: int  # the object, or NOTHING
    t: arb | None = None
    rivals: tuple[int, ...] = ()  # other objects at the very same distance
    gap: float = float("inf")  # to the next object, relative to the distance


class Oracle:
    """A scene, to be asked about single rays."""

    @precision()
    def __init__(self, scene: dict):
        self.solids = [Solid(o) for o in scene["objects"]]
        self.lights = [(balls(light["position"]), balls(light.get("brightness", (1, 1, 1))))
                       for light in scene.get("lights", ())]
        self.background = balls(scene.get("background", (0, 0, 0)))
        tracing = scene.get("tracing", {})
        self.limit, self.max_depth = rational(tracing.get("max_distance", 30.0)), tracing.get("max_depth", 8)
        self.step_size, self.max_iterations = rational(tracing.get("step_size", 0.1)), tracing.get("max_iterations", 20)
        self.tolerance = tracing.get("tolerance", 1e-12)
        self.ambient, self.balanced = arb(rational(tracing.get("ambient", 0))), tracing.get("lights") == "balanced"
        self.opaque_only, self.shared_range = tracing.get("shadows") == "opaque_only", tracing.get("range") == "path"
        self.camera = camera = scene["camera"]
        self.position = balls(camera.get("position", (0, 0, 0)))
        self.v_dir = unit(balls(camera.get("direction", (0, 0, 1))))
        self.v_x = unit(balls(camera["v_x"]) if "v_x" in camera else cross(balls(camera.get("up", (0, 1, 0))), self.v_dir))
        self.v_y = unit(balls(camera["v_y"]) if "v_y" in camera else cross(self.v_dir, self.v_x))
        half = arb(rational(camera.get("fov", 60.0))) / 360
        self.per_pixel = 2 * half.sin_pi() / half.cos_pi() / max(camera["width"], camera["height"])

    @precision()
    def camera_ray(self, row: int, column: int) -> Ray:
        """The ray through the centre of a pixel (section 2, decisions C1 and F5)."""
        x = self.per_pixel * (fmpq(2 * column + 1, 2) - fmpq(self.camera["width"], 2))
        y = self.per_pixel * (fmpq(self.camera["height"], 2) - fmpq(2 * row + 1, 2))
        d = unit(along(along(self.v_dir, self.v_x, x), self.v_y, y))
        return self.started(points(self.position), points(d))

    def started(self, o: Triple, d: Triple) -> Ray:
        """A camera's ray: inside of what is negative at its origin."""
        inside = []
        for solid in self.solids:
            if solid.is_far(o):
                inside.append(False)
                continue
            value = solid.value(o)
            if not _is_signed(value):
                raise Unsettled("f is zero, or not defined, at the camera")
            inside.append(bool(value < 0))
        return Ray(o, d, tuple(inside), self.limit)

    @precision()
    def first_hit(self, ray: Ray) -> Hit:
        firsts = []
        for k, solid in enumerate(self.solids):
            crossings = solid.crossings(ray.o, ray.d, ray.limit, ray.inside[k], ray.leaves == k, only_first=True)
            if crossings:
                firsts.append((crossings[0], k))
        if not firsts:
            return Hit(NOTHING)
        firsts.sort(key=lambda pair: (pair[0].mid().fmpq(), pair[1]))
        t = firsts[0][0]
        same = [k for other, k in firsts if abs(other - t) < arb(APART) * t]
        gap = float(((firsts[1][0] - t) / t).mid()) if len(firsts) > 1 else float("inf")
        return Hit(min(same), t, tuple(k for k in same if k != min(same)), gap)

    @precision()
    def literal_hit(self, ray: Ray) -> Hit:
        """What the literal method finds of a scene of one object (sections 4.1 and 4.2): the sign at every step follows
        from the crossings before it, and Newton starts in the middle of the step. Raises Unsettled where a crossing lies
        at a sample, or where Newton does not arrive."""
        crossings = self.solids[0].crossings(ray.o, ray.d, self.limit, ray.inside[0], leaves=False)
        h, step, passed = self.step_size, 0, 0
        while passed < len(crossings):
            step = int((crossings[passed].mid().fmpq() / h).floor()) + 1
            end = min(step * h, self.limit)
            within = [t for t in crossings[passed:] if t < arb(end)]
            for t in crossings:
                if any(abs(t - arb(end - back)) < arb(CLEAR) * self.limit for back in (0, h)):
                    raise Unsettled("a crossing where the literal method takes a sample")
            if len(within) % 2:
                return Hit(0, self._newton(ray, ((step - 1) * h + end) / 2))
            passed += len(within)
        return Hit(NOTHING)

    def _newton(self, ray: Ray, t: fmpq) -> arb:
        solid = self.solids[0]
        o, d = solid.into(ray.o), solid.into(ray.d, is_direction=True)
        for _ in range(self.max_iterations):
            g = solid.along(o, d, arb(t))
            dt = g.value / g.slope
            if not dt.is_finite() or dt.rad() > arb("1e-20"):
                break
            t -= rational(dt)
            if abs(dt) < arb("1e-14") * (1 + abs(t)):
                return arb(t)
        raise Unsettled("Newton does not arrive")

    @precision()
    def normal_at(self, ray: Ray, hit: Hit) -> Triple:
        """The unit normal against the ray (decision N1): just before the hit, so that powers of f have a gradient too."""
        with precision(4 * BITS):
            before = along(ray.o, ray.d, hit.t.mid().fmpq() * (1 - fmpq(1, 10**30)))
            normal = self.solids[hit.index].normal(before)
        normal = tuple(+c for c in normal)
        return tuple(-c for c in normal) if dot(balls(ray.d), normal) > 0 else normal

    @precision()
    def color(self, ray: Ray, generation: int = 0) -> Triple:
        """Section 4.3: the colour a ray brings back."""
        if generation > self.max_depth:  # decision D1
            return self.background
        hit = self.first_hit(ray)
        if hit.index == NOTHING:
            return self.background
        if hit.rivals:
            raise Unsettled("two objects at one distance")
        solid, point = self.solids[hit.index], points(along(ray.o, ray.d, hit.t))
        normal, d = self.normal_at(ray, hit), balls(ray.d)
        cos1 = -dot(d, normal)
        R, T = solid.reflection, solid.transparency
        color = (arb(0),) * 3
        if (1 - R) * (1 - T) > 0:
            light = self._illumination(ray, hit.index, point, normal)
            color = tuple((1 - R) * (1 - T) * c * i for c, i in zip(solid.color, light))
        left = ray.limit - hit.t.mid().fmpq() if self.shared_range else self.limit  # decisions F4, M5
        follow = lambda v, inside: self.color(Ray(point, points(unit(v)), inside, left, hit.index), generation + 1)
        weight = R * (1 - T)
        refracted = self._refracted(d, normal, cos1, solid.index, ray.inside[hit.index]) if T > 0 else None
        if T > 0 and refracted is None:
            weight += T  # total internal reflection (decision R3)
        if weight > 0:
            color = along(color, follow(along(d, normal, 2 * cos1), ray.inside), weight)
        if refracted is not None:
            through = tuple(side ^ (k == hit.index) for k, side in enumerate(ray.inside))
            color = along(color, follow(refracted, through), T)
        return color

    def _illumination(self, ray: Ray, index: int, point: Triple, normal: Triple) -> Triple:
        """Section 4.3.1, decisions L1 to L3, F1 to F3."""
        total = (self.ambient,) * 3
        for position, brightness in self.lights:
            to_light = along(position, balls(point), -1)
            distance, direction = dot(to_light, to_light).sqrt(), unit(to_light)
            cos = dot(direction, normal)
            if not cos > 0:
                continue
            intensity = arb(1)
            for k, solid in enumerate(self.solids):
                if not solid.casts_shadow or (self.opaque_only and solid.transparency > 0):
                    continue
                crossed = solid.crossings(point, points(direction), rational(distance), ray.inside[k], index == k,
                                          only_first=bool(solid.transparency == 0))
                intensity *= solid.transparency ** len(crossed)
            more = tuple(cos * intensity * b for b in brightness)
            total = tuple(1 - (1 - a) * (1 - b) if self.balanced else a + b for a, b in zip(total, more))
        return total

    @staticmethod
    def _refracted(d: Triple, normal: Triple, cos1: arb, n: arb, leaving: bool) -> Triple | None:
        """The direction of section 4.3.3; None where there is total internal reflection."""
        ratio = n if leaving else 1 / n  # n1 / n2
        sin2_squared = (1 - cos1 * cos1) * ratio * ratio
        if sin2_squared > 1:
            return None
        if not sin2_squared < 1 and ratio != 1:
            raise Unsettled("at the critical angle")
        cos2 = (1 - sin2_squared).nonnegative_part().sqrt()
        return along(tuple(c * ratio for c in along(d, normal, cos1)), normal, -cos2)
