"""The tracer as the document tells it: one recursive function, in NumPy. Slow, short, and the oracle of the fast one.

Every array holds one entry for each of n rays; `inside` is (n, objects). Shared with the wavefront tracer are the scene
as it is read, the surfaces' f and regular form with the elementary functions they call (numbers/functions.py, on NumPy),
and the camera's frame and canvas (camera.py). Everything else is its own: derivatives (`Tangent`), sides, rotations,
steps, Newton, shading; no tables, no boxes, no queues, no Dr.Jit. How rays find what they meet is a `Search`;
`LiteralSearch` is sections 4.1 and 4.2 word for word.
"""

from __future__ import annotations

from typing import Protocol

import numpy as np

from ..numbers.functions import atan2, cbrt, cos, exp, floor, heaviside, log, sin, sqrt, tan
from ..scene.model import SLIVER, Object, Rotation, Scene
from ..tracer.camera import canvas_point, frame


class Search(Protocol):
    """How rays find what they meet."""

    def first_hit(self, o, d, inside, limit):
        """(t, index, used) of each ray's first hit within `limit` (n,); index -1 where there is none.

        `used` is how much of its range a ray has used up when it meets something: t, or whole steps (decision F4).
        """

    def transmittance(self, o, d, inside, distance):
        """The product of the transparencies crossed on the way to a light at `distance`."""


def render(scene: Scene, search: Search | None = None) -> np.ndarray:
    """The colours of `scene`, (height, width, 3)."""
    search = search or LiteralSearch(scene)
    samples, width, height = scene.tracing.samples, scene.camera.width, scene.camera.height
    row, col = (plane.ravel().astype(float) for plane in np.mgrid[:height, :width])
    camera = frame(scene.camera)
    inside = np.array([_is_inside(obj.surface(*_into_frame(obj, camera.v_pos))) for obj in scene.objects])
    total = np.zeros((width * height, 3))
    for sample_row in range(samples):
        for sample_col in range(samples):
            x, y = canvas_point(camera, row, col, sample_row, sample_col, samples)
            d = _normalize(x[:, None] * camera.v_x + y[:, None] * camera.v_y + camera.v_dir)
            o = np.broadcast_to(camera.v_pos, d.shape)
            total += point_color(scene, search, o, d, np.broadcast_to(inside, (len(d), len(inside))),
                                 np.full(len(d), scene.tracing.max_distance), depth=0)
    return (total / samples**2).reshape(height, width, 3)


def point_color(scene: Scene, search: Search, o, d, inside, limit, depth: int) -> np.ndarray:
    """Section 4.3: the colour each ray of range `limit` (n,) brings back, (n, 3)."""
    color = np.tile(np.array(scene.background), (len(d), 1))
    if depth > scene.tracing.max_depth:
        return color
    # the misprint of section 4.3.3.2 (E1) makes directions of NaN: such a ray meets nothing
    usable = np.isfinite(d).all(axis=-1)
    t, index, used = np.full(len(d), np.inf), np.full(len(d), -1), np.full(len(d), np.inf)
    t[usable], index[usable], used[usable] = search.first_hit(o[usable], d[usable], inside[usable], limit[usable])
    met = np.flatnonzero(index >= 0)
    if len(met):
        color[met] = _color_on(scene, search, index[met], o[met], d[met], inside[met], t[met], (limit - used)[met], depth)
    return color


def _color_on(scene, search, index, o, d, inside, t, left, depth):
    """Section 4.3 where rays meet the objects `index`."""
    point, normal = o + t[:, None] * d, np.empty_like(d)
    for k in np.unique(index):
        normal[index == k] = _normal(scene.objects[k], point[index == k])
    normal = np.where(_dot(d, normal) > 0, -normal, normal)
    cos1 = np.minimum(-_dot(d, normal), 1)
    of_material = lambda name: np.array([getattr(obj.material, name) for obj in scene.objects])[index].reshape(len(t), -1)
    R, T = of_material("reflection"), of_material("transparency")

    limit = np.full(len(t), scene.tracing.max_distance)  # M5
    if scene.tracing.range == "path":  # decision F4
        limit = np.where(left > SLIVER * limit, left, 0)
    illumination = np.full_like(point, scene.tracing.ambient)  # decision F2
    for light in scene.lights:  # section 4.3.1
        distance = np.linalg.norm(light.position - point, axis=-1, keepdims=True)
        shadow_dir = (light.position - point) / distance
        cos = _dot(shadow_dir, normal)
        lit = np.flatnonzero(cos[:, 0] > 0)
        intensity = search.transmittance(point[lit], shadow_dir[lit], inside[lit], distance[lit, 0])
        more = cos[lit] * np.array(light.brightness) * intensity[:, None]
        if scene.tracing.lights == "balanced":  # decision F1
            illumination[lit] = 1 - (1 - illumination[lit]) * (1 - more)
        else:
            illumination[lit] += more
    visible = of_material("color") * illumination

    def follow(which, direction, sides):
        """What comes back along `direction`, black for the rays that are not to be followed."""
        brought, which = np.zeros_like(visible), np.flatnonzero(which)
        if len(which):
            brought[which] = point_color(scene, search, point[which], _normalize(direction[which]), sides[which],
                                         limit[which], depth + 1)
        return brought

    leaving, glass = inside[np.arange(len(t)), index][:, None], T > 0
    n = of_material("refractive_index")
    n1, n2 = np.where(leaving, n, 1.0), np.where(leaving, 1.0, n)
    sin1 = np.sqrt(np.maximum(1 - cos1**2, 0))
    total = glass & (sin1 > n2 / n1)  # section 4.3.3: such a ray brings what its reflection brings
    reflected = follow((R > 0) | total, d + 2 * normal * cos1, inside)  # section 4.3.2
    with np.errstate(invalid="ignore"):
        sin2 = sin1 * (n2 / n1 if scene.tracing.refraction == "as_printed" else n1 / n2)
        cos2 = np.sqrt(1 - sin2**2)
        refraction_dir = (d + normal * cos1) * (n1 / n2) - normal * cos2
    through = inside.copy()
    through[np.arange(len(t)), index] ^= True
    refracted = np.where(total, reflected, follow(glass & ~total, refraction_dir, through))

    # section 4.3.4
    return (visible * (1 - R) + np.where(R > 0, reflected * R, 0)) * (1 - T) + np.where(glass, refracted * T, 0)


class LiteralSearch:
    """Sections 4.1 and 4.2: every object is evaluated at every step, all signs are compared, Newton refines."""

    def __init__(self, scene: Scene):
        self.scene, self.tracing = scene, scene.tracing
        self.frames = [(_axes(o.rotation), np.array(o.surface.center), o.surface) for o in scene.objects]

    def _signs(self, o, d, t):
        """f < 0 of every object at o + t d, (n, objects); what is not finite counts as outside (M7)."""
        with np.errstate(all="ignore"):
            return np.stack([_is_inside(surface(*((o - c + t[:, None] * d) @ R).T))
                             for R, c, surface in self.frames], axis=-1)

    def first_hit(self, o, d, inside, limit):
        t_hit, index, used = np.full(len(d), np.inf), np.full(len(d), -1), np.full(len(d), np.inf)
        waiting = np.flatnonzero(limit > 0)
        step = 0
        while len(waiting):
            step += 1
            before, t = (step - 1) * self.tracing.step_size, np.minimum(step * self.tracing.step_size, limit[waiting])
            changed = self._signs(o[waiting], d[waiting], t) != inside[waiting]
            for k in np.flatnonzero(changed.any(axis=0)):  # refine each, the smallest t wins, then scene order (M4)
                rays = waiting[changed[:, k]]
                root = self._newton(k, o[rays], d[rays], 0.5 * (before + t[changed[:, k]]))
                closer = root < t_hit[rays]
                t_hit[rays[closer]], index[rays[closer]] = root[closer], k
            used[waiting] = t
            waiting = waiting[~changed.any(axis=1) & (t < limit[waiting])]
        return t_hit, index, used

    def _newton(self, k, o, d, t):
        rotation, center, surface = self.frames[k]
        origin, direction = ((o - center) @ rotation).T, (d @ rotation).T
        active = np.ones(len(t), bool)
        for _ in range(self.tracing.max_iterations):
            with np.errstate(all="ignore"):
                g = surface(*(Tangent(p, v[None]) for p, v in zip(origin + t * direction, direction)))
                dt = np.where(active, g.value / g.slopes[0], 0.0)
            active &= np.isfinite(dt)
            t = np.where(active, t - dt, t)
            active &= np.abs(dt) > self.tracing.tolerance * np.maximum(1, np.abs(t))
        return t

    def transmittance(self, o, d, inside, distance):
        transparency = transmitted(self.scene)
        intensity, sides = np.ones(len(d)), inside
        if not len(d):
            return intensity
        for step in range(1, 1 + int(np.ceil(distance.max() / self.tracing.step_size))):
            signs = self._signs(o, d, np.minimum(step * self.tracing.step_size, distance))
            intensity = intensity * np.prod(np.where(signs != sides, transparency, 1.0), axis=-1)  # L3
            sides = signs
        return intensity


def transmitted(scene: Scene) -> np.ndarray:
    """By how much each crossing of each object dims light (decisions L3, F3)."""
    return np.array([1.0 if not obj.shadow or (scene.tracing.shadows == "opaque_only" and obj.material.transparency > 0)
                     else obj.material.transparency for obj in scene.objects])


def _normal(obj: Object, point):
    """grad f, normalised (decision N1); from the regular form, see surfaces/heart.py."""
    slopes = np.eye(3)[..., None] + np.zeros(len(point))  # of each coordinate along every axis
    with np.errstate(all="ignore"):
        gradient = obj.surface.regular(*map(Tangent, _into_frame(obj, point), slopes)).slopes.T
        return _normalize(gradient / np.abs(gradient).max(axis=-1, keepdims=True)) @ _axes(obj.rotation).T


class Tangent:
    """A value (n,) and its slopes (k, n) in k directions, by the chain rule on NumPy arrays."""

    __array_ufunc__ = None  # arrays leave mixed operations to this class

    def __init__(self, value, slopes):
        self.value, self.slopes = value, slopes

    @staticmethod
    def of(number) -> Tangent:
        return number if isinstance(number, Tangent) else Tangent(number, 0.0)

    def _chain(self, value, slope) -> Tangent:
        return Tangent(value, slope * self.slopes)

    def __neg__(self):
        return self._chain(-self.value, -1.0)

    def __add__(self, other):
        other = self.of(other)
        return Tangent(self.value + other.value, self.slopes + other.slopes)

    def __mul__(self, other):
        other = self.of(other)
        return Tangent(self.value * other.value, other.value * self.slopes + self.value * other.slopes)

    def __truediv__(self, other):
        other = self.of(other)
        ratio = self.value / other.value
        return Tangent(ratio, (self.slopes - ratio * other.slopes) / other.value)

    def __pow__(self, n: int):
        if n == 0:
            return self._chain(np.ones_like(self.value), 0.0)
        return self._chain(self.value**n, n * self.value ** (n - 1)) if n != 1 else self

    __radd__, __rmul__ = __add__, __mul__
    __sub__ = lambda self, other: self + -other
    __rsub__ = lambda self, other: -self + other
    __rtruediv__ = lambda self, other: self.of(other) / self

    sqrt = lambda self: self._chain(sqrt(self.value), 0.5 / sqrt(self.value))
    cbrt = lambda self: self._chain(cbrt(self.value), 1 / (3 * cbrt(self.value) ** 2))
    sin = lambda self: self._chain(sin(self.value), cos(self.value))
    cos = lambda self: self._chain(cos(self.value), -sin(self.value))
    tan = lambda self: self._chain(tan(self.value), 1 / cos(self.value) ** 2)
    exp = lambda self: self._chain(exp(self.value), exp(self.value))
    log = lambda self: self._chain(log(self.value), 1 / self.value)
    absolute = lambda self: self._chain(np.abs(self.value), np.where(self.value >= 0, 1.0, -1.0))
    floor = lambda self: self._chain(floor(self.value), 0.0)
    heaviside = lambda self: self._chain(heaviside(self.value), 0.0)

    def power(self, exponent) -> Tangent:
        """self ** exponent, a real number or a function: p a^(p - 1) a' + a^p log(a) p'."""
        p = self.of(exponent)
        raised = lambda by: np.where(self.value >= 0, np.abs(self.value) ** by, np.nan)
        value = raised(p.value)
        by_exponent = np.where(value == 0, 0.0, value * log(self.value)) if p is exponent else 0.0
        return Tangent(value, p.value * raised(p.value - 1) * self.slopes + by_exponent * p.slopes)

    power_of = lambda self, base: Tangent(np.full_like(self.value, base), 0.0).power(self)

    def atan2(self, x) -> Tangent:
        """The angle of (x, self): (x y' - y x') / (x^2 + y^2)."""
        x = self.of(x)
        return Tangent(atan2(self.value, x.value),
                       (x.value * self.slopes - self.value * x.slopes) / (x.value**2 + self.value**2))

    atan2_of = lambda self, y: self.of(y).atan2(self)

    def _extremum(self, other, of, first) -> Tangent:
        other = self.of(other)
        return Tangent(of(self.value, other.value), np.where(first(self.value, other.value), self.slopes, other.slopes))

    maximum = lambda self, other: self._extremum(other, np.maximum, np.greater_equal)
    minimum = lambda self, other: self._extremum(other, np.minimum, np.less_equal)


def _axes(rotation: Rotation | None) -> np.ndarray:
    """(3, 3), whose columns are the turned axes of an object: Rodrigues' formula, v cos + k x v sin + k (k.v)(1 - cos)."""
    if rotation is None:
        return np.eye(3)
    k = _normalize(np.array(rotation.axis))
    quarters = round(rotation.degrees / 90)  # what is left is at most 45 degrees: quarter turns are exact
    rest = np.radians(rotation.degrees - 90 * quarters)
    cos, sin = np.cos(rest), np.sin(rest)
    for _ in range(quarters % 4):
        cos, sin = -sin, cos
    return np.stack([v * cos + np.cross(k, v) * sin + k * (k @ v) * (1 - cos) for v in np.eye(3)], axis=-1)


def _into_frame(obj: Object, point):
    """The coordinates (3, ...) of `point` (..., 3) in the object's own frame."""
    return ((point - np.array(obj.surface.center)) @ _axes(obj.rotation)).T


def _is_inside(f):
    return (f < 0) & (f > -np.inf)


def _dot(a, b):
    return np.sum(a * b, axis=-1, keepdims=True)


def _normalize(v):
    with np.errstate(invalid="ignore"):
        return v / np.linalg.norm(v, axis=-1, keepdims=True)
