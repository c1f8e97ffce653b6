"""The document's recursion in NumPy, for many wrong tracers at once: each ray belongs to a tracer, each tracer has mistakes.

A kernel of the reference takes seconds to compile, and every mistake would need its own; here a wave of rays of all tracers
is followed together, and what a mistake changes is a choice by ray. Hits (shapes.py) may miss thin parts, so that what it
says is held against the reference first (causes.py). It decides no verdict, it names causes.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from raytruth.reference_tracer.scene.model import Scene
from raytruth.reference_tracer.scene.placement import is_inside
from raytruth.reference_tracer.tracer.camera import frame
from raytruth.reference_tracer.tracer.given_rays import GivenRays

from .mistakes import Mistakes, filed, moved
from .shapes import Shape

TOGETHER = 1 << 14  # rays, so that what is computed of them stays in the processor's caches
MOST_RAYS = 3_000_000  # of one call


class Exhausted(ArithmeticError):
    """More rays than one call may follow."""


@dataclass
class Rays:
    """One generation; arrays are (3, n), (objects, n), (n,)."""

    o: np.ndarray
    d: np.ndarray
    inside: np.ndarray
    limit: np.ndarray
    weight: np.ndarray
    slot: np.ndarray  # tracer times pixels plus pixel

    def __len__(self):
        return len(self.slot)

    def at(self, which) -> Rays:
        return Rays(self.o[:, which], self.d[:, which], self.inside[:, which], self.limit[which], self.weight[which],
                    self.slot[which])


class Tracers:
    """Tracers of one scene, each with the mistakes that one entry of `sets` has.

    `literal`: hits as the document's steps see them, two changes of sign in one step unseen. Where rays are `given`, they
    take the camera's place, one a column, and no mistake of the camera shows.
    """

    def __init__(self, scene: Scene, sets: Sequence[Mistakes], literal: bool = False, least: float = 1e-5,
                 given: GivenRays | None = None):
        self.scene, self.sets, self.least, self.given = scene, sets, least, given
        self.shapes = [Shape(o) for o in scene.objects]
        ids = {id for s in sets for id in s}
        self.amounts = {id: np.array([s.get(id, 0.0) for s in sets]) for id in ids}
        self.step = scene.tracing.step_size
        steps = self.amounts.get("step-size", np.zeros(len(sets)))
        stepping = sum(self._of(id, slice(None), 0) for id in ("root-unrefined", "one-newton-step")) > 0
        self.h = np.where(steps > 0, steps * self.step, np.where(stepping | literal, self.step, 0.0)) + np.zeros(len(sets))
        if scene.tracing.range == "path":
            self.amounts["range-per-path"] = np.ones(len(sets))
        material = [o.material for o in scene.objects]
        self.R, self.T, self.n = (np.array([getattr(m, name) for m in material])
                                  for name in ("reflection", "transparency", "refractive_index"))
        self.color = np.array([m.color for m in material]).T
        tracing, depth = scene.tracing, np.full(len(sets), scene.tracing.max_depth)
        for id, change in (("one-generation-less", -1), ("one-generation-more", 1)):
            depth = depth + change * (self._of(id, slice(None), 0) > 0)
        self.depth = np.maximum(np.where(self._of("one-generation-only", slice(None), 0) > 0, np.minimum(depth, 1), depth), 0)
        self.max_distance = tracing.max_distance * np.where((m := self._of("max-distance", slice(None), 0)) > 0, m, 1.0) \
            + np.zeros(len(sets))
        self.rays = 0

    def _of(self, id: str, who, absent=None):
        """The amount that each of these tracers has of a mistake; `absent` where none has any."""
        return self.amounts[id][who] if id in self.amounts else absent

    def colors(self, rows: np.ndarray, columns: np.ndarray) -> np.ndarray:
        """(tracers, pixels, 3): the linear colours at these places of the file, before what `mistakes.filed` does."""
        film = np.zeros((3, len(self.sets) * len(rows)))
        rays, generation = self._first_rays(rows, columns), 0
        while len(rays):
            self.rays += len(rays)
            if self.rays > MOST_RAYS:
                raise Exhausted
            more = []
            for start in range(0, len(rays), TOGETHER):
                part = rays.at(slice(start, start + TOGETHER))
                color, secondary = self._interact(part, generation)
                for k in range(3):
                    film[k] += np.bincount(part.slot, color[k] * part.weight, film.shape[1])
                more += secondary
            rays = _joined(more, rays)
            generation += 1
        return np.moveaxis(film.reshape(3, len(self.sets), self.pixels), 0, -1)

    def hits(self, rows: np.ndarray, columns: np.ndarray) -> np.ndarray:
        """(tracers, pixels, 4): the distance and the normal of what is met first through the pixels' centres; 0 where that
        is nothing."""
        rays, parts = self._first_rays(rows, columns, centres=True), []
        self.rays += len(rays)
        for start in range(0, len(rays), TOGETHER):
            part = rays.at(slice(start, start + TOGETHER))
            who, found = part.slot // self.pixels, np.zeros((4, len(part)))
            t, index = self._nearest(part, who)
            met = np.flatnonzero(index >= 0)
            some, t = part.at(met), t[met]
            normal, _ = self._normal(some, who[met], some.o + t * some.d, index[met])
            found[:, met] = t, *normal
            parts.append(found)
        return np.moveaxis(np.concatenate(parts, axis=1).reshape(4, len(self.sets), self.pixels), 0, -1)

    def _first_rays(self, rows, columns, centres: bool = False) -> Rays:
        self.pixels = len(rows)
        return self._camera(rows, columns, centres) if self.given is None else self._given(columns)

    def _given(self, columns) -> Rays:
        o, d = self.given.o[columns], self.given.d[columns]
        sides = np.array([[is_inside(obj, point) for point in o] for obj in self.scene.objects], bool)
        repeated = lambda array: np.tile(array, len(self.sets))
        return Rays(repeated(o.T), repeated(d.T), repeated(sides), np.repeat(self.max_distance, self.pixels),
                    np.ones(len(self.sets) * self.pixels), np.arange(len(self.sets) * self.pixels))

    # --- section 2 -------------------------------------------------------------------------------------------------
    def _camera(self, rows, columns, centres: bool) -> Rays:
        scene, parts = self.scene, []
        camera, n = scene.camera, scene.tracing.samples
        f = frame(camera)
        sides = np.array([[is_inside(o, camera.position)] for o in scene.objects], bool)
        for who, mistakes in enumerate(self.sets):
            row, column = moved(mistakes, rows, columns, camera.height, camera.width)
            own, ratio, (v_x, v_y) = 1 if "one-sample" in mistakes or centres else n, f.ratio, (f.v_x, f.v_y)
            longer, shorter = max(camera.width, camera.height), min(camera.width, camera.height)
            span = 2 * math.tan(math.pi * camera.fov / 360)
            if "fov-not-halved" in mistakes and camera.fov < 90:
                ratio = 2 * math.tan(math.pi * camera.fov / 180) / longer
            if "fov-over-the-shorter-side" in mistakes:
                ratio = ratio * longer / shorter
            if "one-pixel-too-few" in mistakes:
                ratio = span / max(longer - 1, 1)
            if "fixed-axes" in mistakes:
                v_x, v_y = np.eye(3)[:2]
            middle = 0.0 if ("samples-at-corners" in mistakes and not centres) or "pixel-corners" in mistakes else 0.5
            share = 1 / (own if "divided-by-n" in mistakes else own * own)
            for i in range(own):
                for j in range(own):
                    x = ratio * (column + (j + middle) / own - f.width * 0.5)
                    y = ratio * (f.height * 0.5 - (row + (i + middle) / own))
                    d = v_x[:, None] * x + v_y[:, None] * y + f.v_dir[:, None]
                    if "camera-ray-not-normalised" not in mistakes:
                        d = d / np.linalg.norm(d, axis=0)
                    parts.append(Rays(np.broadcast_to(f.v_pos[:, None], d.shape), d,
                                      np.broadcast_to(sides, (len(sides), len(rows))),
                                      np.full(len(rows), self.max_distance[who]), np.full(len(rows), share),
                                      who * self.pixels + np.arange(len(rows))))
        return _joined(parts, None)

    # --- sections 4.1 and 4.2 --------------------------------------------------------------------------------------
    def _nearest(self, rays: Rays, who):
        h, printed = self.h[who], self._of("heart-as-printed", who)
        usable = np.isfinite(rays.d).all(axis=0)
        limit = np.where(usable, rays.limit, -1.0)
        d = np.where(usable, rays.d, 1.0)
        best, index = np.full(len(rays), np.inf), np.full(len(rays), -1)
        unrefined, once = self._of("root-unrefined", who), self._of("one-newton-step", who)
        in_order = self._of("first-in-the-list", who)
        for k, shape in enumerate(self.shapes):
            # specks come from both: Newton ends early at a triple root, and there the gradient vanishes
            own = np.where(printed > 0, self.step, h) if printed is not None and shape.surface.type == "heart" else h
            t = shape.first(rays.o, d, rays.inside[k], limit, own, self.scene.tracing)
            if unrefined is not None or once is not None:
                t = self._rough(shape, rays, d, t, unrefined, once)
            closer = t < best
            if in_order is not None:  # of all that the ray hits, or (2) of what it crosses in the same step
                with np.errstate(divide="ignore", invalid="ignore"):
                    together = (h > 0) & (np.ceil(t / h) == np.ceil(best / h))
                closer &= ~((index >= 0) & ((in_order == 1) | ((in_order == 2) & together)))
            best, index = np.where(closer, t, best), np.where(closer, k, index)
        if (m := self._of("snell-as-printed", who)) is not None and len(
                lost := np.flatnonzero(~usable & (m == 2) & (rays.limit > 0) & rays.inside.any(axis=0))):
            # f is NaN, which is not inside: the first sample differs, and Newton ends where it began
            best[lost], index[lost] = 0.5 * self.step, rays.inside[:, lost].argmax(axis=0)
        return best, index

    def _rough(self, shape: Shape, rays: Rays, d, t, unrefined, once):
        """The middle of the step that holds t, or one Newton step from it."""
        unrefined = np.zeros(len(t), bool) if unrefined is None else unrefined > 0
        once = np.zeros(len(t), bool) if once is None else once > 0
        some = np.flatnonzero((unrefined | once) & np.isfinite(t))
        if not len(some):
            return t
        h, t = self.step, t.copy()
        before = (np.ceil(t[some] / h) - 1) * h
        middle = 0.5 * (before + np.minimum(before + h, rays.limit[some]))
        g, slope = shape.slope(shape.into(rays.o[:, some] - shape.center), shape.into(d[:, some]), middle)
        with np.errstate(all="ignore"):
            step = g / slope
        t[some] = np.where(once[some] & np.isfinite(step), middle - step, middle)
        return t

    def _transmittance(self, o, d, inside, distance, who):
        """Section 4.3.1: what is left of the light from `distance` away."""
        left = np.ones(len(distance))
        none, opaque, full = (self._of(id, who, np.zeros(1)) > 0 for id in (
            "no-shadows", "glass-casts-no-shadow", "glass-casts-full-shadow"))
        once = self._of("transparency-once", who)
        past = self._of("shadow-past-the-light", who)
        if past is not None:
            distance = np.where(past > 0, self.max_distance[who], distance)
        h = self.h[who]
        for k, shape in enumerate(self.shapes):
            if not self.scene.casts_shadow(self.scene.objects[k]) or "shadow" not in self.scene.tracing.effects:
                continue
            T = self.T[k]
            rays = np.flatnonzero((left > 0) & ~none & ~(opaque & (T > 0)))
            if not len(rays):
                continue
            count = shape.count(o[:, rays], d[:, rays], inside[k, rays], distance[rays], h[rays], self.step)
            factor = T ** count.astype(float)
            if once is not None:
                entered = (count + ~inside[k, rays]) // 2
                factor = np.where(once[rays] == 1, np.where(count > 0, T, 1.0), np.where(once[rays] == 2, T**entered, factor))
            left[rays] *= np.where(np.broadcast_to(full, left.shape)[rays] & (count > 0), 0.0, factor)
        return left

    # --- section 4.3 -----------------------------------------------------------------------------------------------
    def _interact(self, rays: Rays, generation: int):
        """(3, n) own colours, and lists of secondary rays."""
        who, scene = rays.slot // self.pixels, self.scene
        background = np.array(scene.background)[:, None] * np.ones(len(rays))
        if (m := self._of("black-background", who)) is not None:
            background = np.where(m > 0, 0.0, background)
        ended = generation > self.depth[who]
        if (m := self._of("black-at-the-end", who)) is not None:
            background = np.where(ended & (m > 0), 0.0, background)
        t, index = np.full(len(rays), np.inf), np.full(len(rays), -1)
        going = np.flatnonzero(~ended)
        if len(going):
            t[going], index[going] = self._nearest(rays.at(going), who[going])
        color = background
        met = np.flatnonzero(index >= 0)
        if not len(met):
            return color, []
        rays, who, t, k = rays.at(met), who[met], t[met], index[met]
        point = rays.o + t * rays.d
        normal, cos1 = self._normal(rays, who, point, k)
        R, T = self.R[k], self.T[k]

        left = self.max_distance[who]
        if (m := self._of("range-per-path", who)) is not None:
            h = self.h[who]  # whole steps are used up where steps are taken
            with np.errstate(divide="ignore", invalid="ignore"):
                used = np.where(h > 0, np.minimum(np.ceil(t / h) * h, rays.limit), t)
            left = np.where(m > 0, np.maximum(rays.limit - used, 0), left)
        own = (1 - R) * (1 - T)
        for id, weight in (("own-colour-in-full", 1 - T), ("own-colour-beside-t", 1 - R), ("weights-subtracted", 1 - R - T)):
            if (m := self._of(id, who)) is not None:
                own = np.where(m > 0, weight, own)
        visible = self.color[:, k] * self._illumination(rays, who, point, normal, own != 0)
        if (m := self._of("colour-squared", who)) is not None:
            visible = np.where(m > 0, visible * self.color[:, k], visible)
        color[:, met] = visible * own
        return color, self._secondary(rays, who, point, normal, cos1, k, left, background, color, met)

    def _normal(self, rays, who, point, k):
        """The normal, turned against the ray (N1), and cos(phi1)."""
        normal, printed = np.zeros_like(point), self._of("heart-as-printed", who)
        for j, shape in enumerate(self.shapes):
            here = np.flatnonzero(k == j)
            if len(here):
                wrong = printed[here] > 0 if printed is not None and shape.surface.type == "heart" else None
                normal[:, here] = shape.gradient(point[:, here], wrong)
        with np.errstate(all="ignore"):
            length = np.linalg.norm(normal, axis=0)
            if (m := self._of("normal-not-normalised", who)) is not None:
                length = np.where(m > 0, 1.0, length)
            normal = normal / length
        # no normal: the reference faces the ray; a program that divides 0 by 0 shows black
        lost = ~np.isfinite(normal).all(axis=0)
        normal = np.where(lost, -rays.d, normal)
        cos1 = -(rays.d * normal).sum(axis=0)
        flip = cos1 < 0
        if (m := self._of("normal-not-turned", who)) is not None:
            cos1 = np.where(flip & (m != 1), -cos1, cos1)  # 1: both as they are; 2: the cosine alone is made positive
            flip &= m == 0
        else:
            cos1 = np.abs(cos1)
        if (m := self._of("normal-inverted", who)) is not None:
            flip = np.where(m > 0, ~flip, flip)
            cos1 = np.where(m == 1, -cos1, cos1)  # 2: the cosine alone is made positive
        normal = np.where(flip, -normal, normal)
        return normal, cos1

    def _illumination(self, rays, who, point, normal, wanted):
        total = np.zeros_like(point) + self.scene.tracing.ambient
        if (m := self._of("ambient", who)) is not None:
            total = np.where(m > 0, m, total)
        lights, balanced = self.scene.lights, self._of("balanced-lights", who)
        if self.scene.tracing.lights == "balanced":
            balanced = np.ones(len(who))
        for j, light in enumerate(lights):
            to_light = np.array(light.position)[:, None] - point
            distance = np.linalg.norm(to_light, axis=0)
            with np.errstate(all="ignore"):
                direction = to_light / distance
            cos = (direction * normal).sum(axis=0)
            back = self._of("lit-from-behind", who)
            if back is not None:
                cos = np.where(back > 0, np.abs(cos), cos)
            asked = wanted & (cos > 0)
            if (m := self._of("cos-not-clamped", who)) is not None:
                asked |= wanted & (m > 0)
            for id, only in (("first-light-only", 0), ("last-light-only", len(lights) - 1)):
                if j != only and (m := self._of(id, who)) is not None:
                    asked &= m == 0
            asked = np.flatnonzero(asked)
            o, inside = self._start(rays.inside[:, asked], who[asked], point[:, asked], direction[:, asked], normal[:, asked])
            arrives = self._transmittance(o, direction[:, asked], inside, distance[asked], who[asked])
            per_brightness = np.zeros(len(cos))
            per_brightness[asked] = cos[asked] * arrives
            for id, power in (("falls-off-squared", 2), ("falls-off", 1)):
                if (m := self._of(id, who)) is not None:
                    per_brightness = np.where(m > 0, per_brightness / distance**power, per_brightness)
            brightness = np.array(light.brightness)[:, None]
            if (m := self._of("lights-exchanged", who)) is not None:
                brightness = np.where(m > 0, np.array(lights[len(lights) - 1 - j].brightness)[:, None], brightness)
            if (m := self._of("brightness-squared", who)) is not None:
                brightness = np.where(m > 0, brightness**2, brightness)
            light = brightness * per_brightness
            more = total + light
            total = more if balanced is None else np.where(balanced > 0, total + light * (1 - total), more)
        if (m := self._of("mean-of-lights", who)) is not None and lights:
            total = np.where(m > 0, total / len(lights), total)
        if (m := self._of("illumination-clamped", who)) is not None:
            total = np.where(m > 0, np.clip(total, 0, 1), total)
        return total

    def _start(self, inside, who, point, direction, normal):
        """Where a secondary ray starts, and on which sides: at the point, on those it inherits (M3)."""
        noise = self._of("side-from-the-sign", who)
        along, beside = self._of("offset-along-the-ray", who), self._of("offset-along-the-normal", who)
        if along is not None:
            point = point + along * direction
        if beside is not None:
            point = point + beside * normal
        anew = sum((m > 0 for m in (noise, along, beside) if m is not None), start=np.zeros(len(who), bool))
        if anew.any():
            inside, rays = inside.copy(), np.flatnonzero(anew)
            at = point[:, rays]
            if noise is not None:  # a draw of what rounding decides
                random = np.random.default_rng(7)
                at = at * (1 + 2e-16 * random.standard_normal(at.shape) * np.maximum(noise[rays], 0))
            for k, shape in enumerate(self.shapes):
                inside[k, rays] = shape.is_inside(at)
        return point, inside

    def _secondary(self, rays, who, point, normal, cos1, k, left, background, color, met):
        R, T = self.R[k], self.T[k]
        cos1 = np.minimum(cos1, 1)
        factor = 2.0
        if (m := self._of("reflected-short", who)) is not None:
            factor = np.where(m > 0, 1.0, 2.0)
        reflected = rays.d + normal * (factor * cos1)
        weight = R * (1 - T)
        if (m := self._of("reflection-weighs-r", who)) is not None:
            weight = np.where(m > 0, R, weight)
        if (m := self._of("no-reflection", who)) is not None:
            weight = np.where(m > 0, 0.0, weight)
        if "reflection" not in self.scene.tracing.effects:
            color[:, met] += background[:, met] * weight
            weight = np.zeros_like(weight)
        parts = []
        if self.T.any():
            if "refraction" in self.scene.tracing.effects:
                through, total, direction = self._refracted(rays, who, normal, cos1, k)
                own = T
                for id in ("total-reflection-lost", "no-refraction"):
                    if (m := self._of(id, who)) is not None:
                        own = np.where(m > 0, 0.0, own)
                if (m := self._of("total-reflection-weighs-r", who)) is not None:
                    own = np.where(m > 0, R, own)
                weight = weight + np.where(total, own, 0.0)
                if (m := self._of("no-refraction", who)) is not None:
                    T = np.where(m > 0, 0.0, T)
                parts.append(self._sent(rays, who, point, direction, normal, np.where(total, 0.0, T), through, left))
            else:
                color[:, met] += background[:, met] * T
        parts.append(self._sent(rays, who, point, reflected, normal, weight, rays.inside, left))
        return [p for p in parts if len(p)]

    def _refracted(self, rays, who, normal, cos1, k):
        leaving = rays.inside[k, np.arange(len(k))]
        enters = ~leaving
        if (m := self._of("indices-not-swapped-on-leaving", who)) is not None:
            enters = enters | (m > 0)
        if (m := self._of("indices-inverted", who)) is not None:
            enters = np.where(m > 0, ~enters, enters)
        n1, n2 = np.where(enters, 1.0, self.n[k]), np.where(enters, self.n[k], 1.0)
        if (m := self._of("not-refracted", who)) is not None:
            n1, n2 = np.where(m > 0, 1.0, n1), np.where(m > 0, 1.0, n2)
        sin1 = np.sqrt(np.maximum(1 - cos1**2, 0))
        total = sin1 > n2 / n1
        if (m := self._of("never-totally-reflected", who)) is not None:
            total &= m == 0
        ratio = n1 / n2
        printed = self._of("snell-as-printed", who, np.zeros(1)) > 0
        if self.scene.tracing.refraction == "as_printed":
            printed = np.ones(1, bool)
        sin2 = sin1 * np.where(printed, n2 / n1, ratio)
        with np.errstate(invalid="ignore"):
            cos2 = np.sqrt(np.where(printed, 1 - sin2**2, np.maximum(1 - sin2**2, 0)))
        direction = (rays.d + normal * cos1) * ratio - normal * cos2
        through = rays.inside.copy()
        through[k, np.arange(len(k))] ^= True
        return through, total, direction

    def _sent(self, rays, who, point, direction, normal, weight, inside, left) -> Rays:
        with np.errstate(invalid="ignore"):
            direction = direction / np.linalg.norm(direction, axis=0)
        go = np.flatnonzero(np.abs(weight * rays.weight) > self.least)
        point, inside = self._start(inside[:, go], who[go], point[:, go], direction[:, go], normal[:, go])
        return Rays(point, direction[:, go], inside, left[go], (weight * rays.weight)[go], rays.slot[go])


def _joined(parts: list[Rays], like: Rays | None) -> Rays:
    if not parts:
        return like.at(slice(0))
    join = lambda name: np.concatenate([getattr(p, name) for p in parts], axis=-1)
    return Rays(*map(join, ("o", "d", "inside", "limit", "weight", "slot")))


def rendered(scene: Scene, mistakes: Mistakes, levels: int | None = None, literal: bool = False) -> np.ndarray:
    """The whole picture of a program with `mistakes`, (h, w, 3), as its file says it; see `mistakes.filed` for `levels`."""
    rows, columns = (p.ravel() for p in np.mgrid[:scene.camera.height, :scene.camera.width])
    color = Tracers(scene, [mistakes], literal).colors(rows, columns)[0]
    return filed(mistakes, color, levels).reshape(scene.camera.height, scene.camera.width, 3)
