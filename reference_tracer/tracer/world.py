"""A scene as kernels see it: the nearest hit, the normal there, and the light that gets through."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import drjit as dr

from .. import first_hit
from ..backend import Backend
from ..scene.model import EFFECTS, SLIVER, Object, Scene, Tracing
from ..scene.placement import is_inside
from .camera import canvas_point, frame
from .families import Family, Member
from .optics import Optics
from .rays import Hit, Ray, Sides
from .ties import Margin, first_of_tied


@dataclass
class Material:
    """Section 3, gathered for every lane; what no object of the scene uses is None and costs nothing."""

    color: object  # Vector
    reflection: object | None  # Float
    transparency: object | None  # Float
    refractive_index: object | None  # Float


class World:
    """A scene bound to array types and to a first-hit method; `nearest`, `normal`, `transmittance` are its queries.

    A subclass, with `optics` or queries of its own, is another tracer: `render.Renderer` takes it.
    """

    optics = Optics()

    def __init__(self, scene: Scene, method: str, arrays: Backend):
        self.scene, self.arrays, self.method = scene, arrays, method
        self.object_count = len(scene.objects)
        groups: dict[tuple, list[int]] = {}
        objects = [self.traced(obj) for obj in scene.objects]
        for index, obj in enumerate(objects):
            own = (obj.first_hit.method, obj.first_hit.step_size or 0) if obj.first_hit else ("", 0)
            groups.setdefault((obj.surface.family, obj.surface.sign_outside, own, scene.casts_shadow(obj)),
                              []).append(index)
        self.families = [
            Family(arrays, indices, [objects[i] for i in indices],
                   first_hit.choose(method, objects[indices[0]], scene.tracing, arrays), casts_shadow)
            for (*_, casts_shadow), indices in sorted(groups.items())]  # sorted: scenes with the same families share kernels
        self.vouching = [f for f in self.families if f.method.vouches] if self.object_count > 1 else []

        materials = [o.material for o in scene.objects]
        self.reflective = any(m.reflection > 0 for m in materials)
        self.transparent = any(m.transparency > 0 for m in materials)
        self.dims = self.transparent and scene.tracing.shadows == "attenuate"
        # a kernel without ambient light starts from a literal zero (decision F2)
        self.ambient = arrays.constant(scene.tracing.ambient) if scene.tracing.ambient else 0.0
        self.traces = {effect: effect in scene.tracing.effects for effect in EFFECTS}
        self.max_distance = arrays.constant(scene.tracing.max_distance)
        self.background = [arrays.constant(c) for c in scene.background]
        self.light_count = arrays.count(len(scene.lights))

    def traced(self, obj: Object) -> Object:
        """What stands for `obj` in the families."""
        return obj

    # --- tables ----------------------------------------------------------------------------------------------------
    def _column(self, values):
        column = self.arrays.Float(list(values) or [0.0])  # a table without rows is never read, but must exist
        dr.make_opaque(column)
        return column

    @cached_property
    def _material_columns(self):
        rows = [o.material for o in self.scene.objects]
        return ([self._column(m.color[k] for m in rows) for k in range(3)],
                *(self._column(getattr(m, name) for m in rows)
                  for name in ("reflection", "transparency", "refractive_index")))

    @cached_property
    def _place_of_object(self):
        """For every object its family and its row there."""
        family, row = [0] * self.object_count, [0] * self.object_count
        for k, f in enumerate(self.families):
            for j, index in enumerate(f.indices):
                family[index], row[index] = k, j
        columns = self.arrays.UInt(family), self.arrays.UInt(row)
        dr.make_opaque(columns)
        return columns

    @cached_property
    def _light_columns(self):
        """Positions and brightnesses, three columns each."""
        return [[self._column(getattr(light, name)[k] for light in self.scene.lights) for k in range(3)]
                for name in ("position", "brightness")]

    def light(self, j):
        """Position and brightness (Vectors) of light `j`."""
        pick = lambda columns: self.arrays.Vector(*(dr.gather(self.arrays.Float, c, j) for c in columns))
        position, brightness = self._light_columns
        return pick(position), pick(brightness)

    def material(self, index, active) -> Material:
        color, reflection, transparency, refractive_index = self._material_columns
        pick = lambda column: dr.gather(self.arrays.Float, column, index, active)
        return Material(self.arrays.Vector(*map(pick, color)),
                        pick(reflection) if self.reflective else None,
                        pick(transparency) if self.transparent else None,
                        pick(refractive_index) if self.transparent else None)

    def camera_sides(self) -> Sides:
        """The side of every object the camera is on: the sign of f at its position (decision M3)."""
        return Sides.from_flags(self.arrays.Bits, [is_inside(o, self.scene.camera.position, self.literal(o))
                                                   for o in self.scene.objects])

    def literal(self, obj) -> bool:
        """Whether the sign of f as written decides on which side of `obj` a ray begins."""
        return (obj.first_hit.method if obj.first_hit else self.method) == "paper"

    @cached_property
    def _generations(self):
        return [self.arrays.count(k) for k in range(self.scene.tracing.max_depth + 1)]

    def generation(self, k: int):
        """The number `k` of a generation, as kernels read it."""
        return self._generations[k]

    @cached_property
    def _brightest(self) -> float:
        """No ray returns more in any channel: weights of a interaction never add up to more than 1."""
        light = [_brightest(self.scene.tracing, [light.brightness[k] for light in self.scene.lights]) for k in range(3)]
        return max(max(max(self.scene.background[k], *(o.material.color[k] * light[k] for o in self.scene.objects))
                       for k in range(3)), 1e-300)

    @cached_property
    def color_unit(self) -> float:
        """The power of two of which films count colours in whole numbers (`Film`).

        The n x n samples of a pixel add up to at most n^2 `_brightest` < 2^e. In units of 2^(e - 62) that stays below
        2^62; the room up to 2^63 is for the rounding of weights and, half a unit a ray, of shares. Up to 16 x 16 samples
        a unit is less than what fp64 rounds of the brightest colour, 2^-53 of it.
        """
        _, e = math.frexp(self._brightest * self.scene.tracing.samples**2)
        return 2.0 ** max(e - 62, -1022)  # so that its reciprocal is finite

    @cached_property
    def units_of_color(self):
        """1 / `color_unit`, as kernels read it (fp64 whatever the precision: single has no room for large powers)."""
        return dr.opaque(dr.float64_array_t(self.arrays.Float), 1 / self.color_unit)

    @cached_property
    def _least_weights(self):
        generations = range(self.scene.tracing.max_depth + 1)
        return [self.arrays.constant(self.scene.tracing.cutoff * 2.0**-k / self._brightest) for k in generations]

    def least_weight(self, generation: int):
        """Rays of `generation` at or below this weight in their pixel are not traced (`cutoff` of the scene).

        A ray left out in generation g changes its pixel by at most cutoff / 2^g. Every interaction has two secondary rays
        at most, so that over all rays left out 1 / 2^g adds up to no more than 1 (Kraft's inequality).
        """
        return self._least_weights[generation]

    @property
    def variables(self) -> list:
        """All arrays that kernels read of the world, for recordings of them."""
        canvas, axes, sides = self._camera
        return [self.max_distance, self.ambient, self.background, self.units_of_color, self.light_count, self._material_columns,
                self._place_of_object, self._light_columns, [family.variables for family in self.families],
                canvas.ratio, canvas.width, canvas.height, self.columns, axes, sides.words]

    @cached_property
    def _camera(self):
        arrays, f = self.arrays, frame(self.scene.camera)
        return (f.mapped(arrays.constant), [arrays.vector(v.tolist()) for v in (f.v_x, f.v_y, f.v_dir, f.v_pos)],
                self.camera_sides())

    @cached_property
    def columns(self):
        """The width of the picture in pixels (UInt)."""
        return self.arrays.count(self.scene.camera.width)

    def camera_ray(self, row, column, sample_row, sample_column, samples: int) -> Ray:
        """The ray through a sample of n x n of a pixel, all UInt arrays (sections 2 and 5)."""
        Float = self.arrays.Float
        canvas, (v_x, v_y, v_dir, v_pos), sides = self._camera
        x, y = canvas_point(canvas, Float(row), Float(column), Float(sample_row), Float(sample_column), samples)
        width = dr.width(row)
        left = self.max_distance + dr.zeros(Float, width) if self.scene.tracing.range == "path" else None
        return Ray(v_pos + dr.zeros(self.arrays.Vector, width), dr.normalize(x * v_x + y * v_y + v_dir),
                   Sides([word + dr.zeros(self.arrays.Bits, width) for word in sides.words]), left)

    # --- queries ---------------------------------------------------------------------------------------------------
    def nearest(self, ray: Ray) -> Hit:
        """The first crossing of each ray with any object within its range (decisions M1, M4, M5, F4)."""
        Float, UInt = self.arrays.Float, self.arrays.UInt
        usable = dr.isfinite(dr.squared_norm(ray.d))
        hit = Hit(t=Float(math.inf), order=dr.select(usable, self.range_of(ray), 0),
                  index=UInt(self.object_count), undecided=~usable)
        state = hit.t, hit.order, hit.index, hit.undecided
        if not self.vouching:
            for family in self.families:
                state = self._nearest_of(family, ray, state)
            return Hit(*state)
        margin, state = Margin(ray), (*state, Float(math.inf))
        for family in self.families:
            state = self._nearest_of(family, ray, state, margin)
        hit, second = Hit(*state[:4]), state[4]
        close = (hit.index < self.object_count) & (second <= margin.end(hit.order))
        hit.index, hit.undecided = self.first_of_tied(ray, hit, close)
        return hit

    def first_of_tied(self, ray: Ray, hit: Hit, close):
        """Decision M4 where `close` (Bool) says that another object may tie with the hit: (index, undecided)."""
        return first_of_tied(self.vouching, ray, hit, close)

    def _nearest_of(self, family: Family, ray: Ray, state: tuple, margin: Margin | None = None) -> tuple:
        """The nearer of the hit `state` and the first crossing with the family's objects; with it, where there is a
        `margin`, the second smallest order."""
        looks_beyond = margin is not None and family.method.vouches  # the literal method's limit is a sample of its own

        def step(member: Member, t, order, index, undecided, *second):
            limit = margin.end(order) if looks_beyond else order
            c = family.method.first(member.solid, member.local(ray.o, ray.d), ray.sides.test(member.index), limit)
            earlier = (c.t < t) | ((c.t == t) & (member.index < index))
            closer = c.found & ((c.order < order) | ((c.order == order) & earlier))
            if second:
                larger = dr.maximum(order, dr.select(c.found, c.order, dr.inf))
                second = (dr.minimum(second[0], larger),)
            return (dr.select(closer, c.t, t), dr.select(closer, c.order, order),
                    dr.select(closer, member.index, index), undecided | c.undecided, *second)

        # the ray from within a solid starts within its ball: none is left out
        return family.fold(step, state, lambda ball, t, order, *_: ball.may_meet(ray.o, ray.d, order))

    def range_of(self, ray: Ray):
        """How far each ray reaches (Float): max_distance, or what its parent left of it (decisions M5, F4)."""
        return self.max_distance if ray.left is None else ray.left

    def range_after(self, ray: Ray, hit: Hit):
        """What a ray that met `hit` leaves of its range to its children (Float; decision F4); None: each has its own (M5)."""
        if ray.left is None:
            return None
        left = ray.left - hit.order
        return dr.select(left > SLIVER * self.max_distance, left, 0)

    def normal(self, point, index, active):
        """grad f at `point` of object `index`, normalised; not yet turned against the ray.

        NaN where the gradient is zero, not finite, or so small that underflow has taken digits of it.
        """
        family_of, row_of = (dr.gather(self.arrays.UInt, column, index, active) for column in self._place_of_object)
        gradient = dr.zeros(self.arrays.Vector, dr.width(index))
        for k, family in enumerate(self.families):
            here = active & (family_of == k)
            gradient = dr.if_stmt((gradient,), here, lambda _: family.member(row_of, here).normal_at(point), lambda g: g)
        # by its largest component first: the square of what is beyond 1e154 overflows
        size = dr.max(dr.abs(gradient))
        gradient /= size
        return dr.select(size >= dr.smallest(self.arrays.Float), gradient / dr.norm(gradient), dr.nan)

    def transmittance(self, ray: Ray, distance, active):
        """The part of a light's intensity that reaches the ray's origin from `distance` away (section 4.3.1, L3).

        Every crossing multiplies by the transparency of the object crossed. Returns (Float, Bool undecided).
        """
        intensity = dr.select(active, self.arrays.Float(1), 0)
        undecided = self.arrays.Bool(False)
        if self.traces["shadow"]:
            for family in self.families:
                if not family.casts_shadow:
                    continue
                intensity, undecided = self._light_through_family(family, ray, distance, intensity, undecided)
        return intensity, undecided

    def _light_through_family(self, family: Family, ray: Ray, distance, intensity, undecided):
        def step(member: Member, intensity, undecided):
            # light that is gone already needs no more tests
            return dr.if_stmt((intensity, undecided), intensity > 0,
                              lambda i, u: self._dimmed_by(family, member, ray, distance, i, u), lambda *state: state)

        return family.fold(step, (intensity, undecided),
                           lambda ball, intensity, _: (intensity > 0) & ball.may_meet(ray.o, ray.d, distance))

    def _dimmed_by(self, family: Family, member: Member, ray: Ray, distance, intensity, undecided):
        if self.dims:
            transparency = dr.gather(self.arrays.Float, self._material_columns[2], member.index)
            opaque = transparency == 0
        else:
            opaque = self.arrays.Bool(True)
        count, unsure = family.method.crossings(member.solid, member.local(ray.o, ray.d),
                                                ray.sides.test(member.index), distance, opaque)
        left = (self.optics.attenuated(intensity, transparency, count) if self.dims
                else dr.select(count > 0, 0, intensity))
        return left, undecided | unsure


def _brightest(tracing: Tracing, lights: list[float]) -> float:
    """No point is lit more by lights of these brightnesses, one channel of each (decisions F1, F2)."""
    lights = [tracing.ambient, *lights]
    if tracing.lights == "sum":
        return sum(lights)
    if max(lights) <= 1:
        return 1 - math.prod(1 - light for light in lights)
    return 1 + math.prod(max(1, light - 1) for light in lights)  # 1 - light lies between 1 and 1 - its brightness
