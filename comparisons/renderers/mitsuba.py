"""Mitsuba 3 on a scene: Mitsuba finds the intersections, and sections 4.3.1 to 4.3.4 are evaluated on them.

Written from the document and its decisions, in Mitsuba's fp32 types, and sharing no shading code with the reference:
an error of the one is a difference to the other. The law of refraction is always Snell's (decision E1).
"""

from __future__ import annotations

import time
from dataclasses import dataclass

import numpy as np

from raytruth.converters.mesh import largest
from raytruth.converters.mitsuba import MitsubaScene, convert, document_directions, pixel_directions
from raytruth.converters.mitsuba.crossings import OFFSET, MitsubaHit, MitsubaIntersector, spawn
from raytruth.converters.mitsuba.shapes import native
from raytruth.converters.mitsuba.variant import dr, mi
from raytruth.reference_tracer.errors import UnsupportedError
from raytruth.reference_tracer.scene.model import Scene
from raytruth.reference_tracer.scene.placement import is_inside
from raytruth.reference_tracer.tracer.rays import Sides
from raytruth.reference_tracer.tracer.render import HIT, MISS, UNDECIDED, Picture

from .reference import LONG

MOST_RAYS = 1 << 19


def render(scene: Scene, *, shapes: str = "mesh", resolution: int = 256, error: float | None = None,
           share: float = 1.0, offset: float = OFFSET, refined: bool = False, repeat: bool = True,
           require_native: bool = False) -> Picture:
    """The picture of `scene` on Mitsuba's geometry; see `converters.mitsuba.convert` for the options.

    `refined` moves hits on meshes onto f; see `converters.mitsuba.refine` for what that leaves to compare.

    The metadata keeps apart the seconds to build the scene, to trace it first (kernels are compiled then) and, if
    that was quick and `repeat`, to trace it again. Raises InputError for impossible meshes, UnsupportedError where
    native shapes are required and there are none.
    """
    if require_native and not any(native(obj, scene) for obj in scene.objects):
        raise UnsupportedError("not applicable: Mitsuba has no shape for any of these surfaces; meshes are another renderer's")
    converted = convert(scene, shapes, resolution, error, share)
    tracer = _Tracer(scene, converted, offset, refined)
    planes, rays, first, cpu = _timed(tracer)
    warm = _timed(tracer)[2] if repeat and first < LONG else None
    camera = scene.camera
    picture = Picture(scene=scene, **{name: plane.reshape(camera.height, camera.width, *plane.shape[1:])
                                      for name, plane in planes.items()})
    picture.metadata = {
        "scene": scene.name, "scene_hash": scene.hash, "renderer": "mitsuba", "mitsuba": mi.__version__,
        "precision": 32, "shapes": shapes, "resolution": resolution if error is None else None, "mesh_error": error,
        "refined": refined,
        "native_shapes": sum(p.kind == "native" for p in converted.parts),
        "grids": sum(p.kind == "sdfgrid" for p in converted.parts),
        "errors": [part.error for part in converted.parts], "tilts": [part.tilt for part in converted.parts],
        # where hits are moved onto f, so are their normals
        "normal_errors": [0.0 if refined and part.kind == "mesh" else part.normal_error for part in converted.parts],
        "triangles": converted.triangles, "measured_mesh_error": largest(p.error for p in converted.parts),
        "clipped": "; ".join(f"object {i}: {p.clipped}" for i, p in enumerate(converted.parts) if p.clipped),
        "camera_difference": tracer.camera_difference(), "rays": rays, "build": converted.seconds,
        "first": first, "warm": warm, "cpu": cpu}
    return picture


def _timed(tracer: _Tracer):
    """The planes, the number of rays, and the seconds they took: of the clock on the wall, and of the processor."""
    start, cpu = time.perf_counter(), time.process_time()
    planes, rays = tracer.picture()
    return planes, rays, time.perf_counter() - start, time.process_time() - cpu


@dataclass
class _Rays:
    """Rays of one generation; `weight` is each one's share in the colour of pixel `slot`."""

    o: object  # mi.Point3f
    d: object  # mi.Vector3f, unit
    sides: Sides
    left: object  # mi.Float, each one's range
    weight: object  # mi.Float
    slot: object  # mi.UInt32


class _Tracer:
    """A scene bound to its conversion."""

    def __init__(self, scene: Scene, converted: MitsubaScene, offset: float = OFFSET, refined: bool = False):
        self.document, self.converted = scene, converted
        self.crossings = MitsubaIntersector(scene, converted, offset, refined)
        materials = [o.material for o in scene.objects]
        column = lambda values: mi.Float([float(v) for v in values] or [0.0])  # an empty one cannot be read, even never
        self.color = [column(m.color[k] for m in materials) for k in range(3)]
        self.reflection = column(m.reflection for m in materials)
        self.transparency = column(m.transparency for m in materials)
        self.refractive_index = column(m.refractive_index for m in materials)
        self.light_position = [column(light.position[k] for light in scene.lights) for k in range(3)]
        self.light_brightness = [column(light.brightness[k] for light in scene.lights) for k in range(3)]
        self.lights = dr.opaque(mi.UInt32, len(scene.lights))
        self.ambient = dr.opaque(mi.Float, scene.tracing.ambient)
        self.max_distance = dr.opaque(mi.Float, scene.tracing.max_distance)
        self.background = mi.Color3f(*(dr.opaque(mi.Float, c) for c in scene.background))
        self.transparent = any(m.transparency > 0 for m in materials)
        self.shiny = self.transparent or any(m.reflection > 0 for m in materials)
        self.sides = Sides.from_flags(mi.UInt64, [is_inside(o, scene.camera.position) for o in scene.objects])

    # --- the document's shading --------------------------------------------------------------------------------------
    @dr.syntax
    def illumination(self, hit: MitsubaHit, sides: Sides, active):
        """Section 4.3.1: the lights' cos(phi) * brightness * intensity, together (decisions L1 to L3, F1, F2)."""
        total, lost, j = mi.Color3f(self.ambient), mi.Bool(False), mi.UInt32(0)
        balanced = self.document.tracing.lights == "balanced"
        while j < self.lights:
            position = mi.Point3f(*(dr.gather(mi.Float, c, j) for c in self.light_position))
            brightness = mi.Color3f(*(dr.gather(mi.Float, c, j) for c in self.light_brightness))
            shadow_dir = dr.normalize(position - hit.p)
            cos = dr.dot(shadow_dir, hit.normal)
            origin = spawn(hit.p, hit.facet, shadow_dir, self.crossings.offset)
            lit = active & (cos > 0)
            intensity, unsure = self.crossings.transmittance(origin, shadow_dir, dr.norm(position - origin), sides, lit)
            more = brightness * dr.select(lit, cos * intensity, 0)
            total = 1 - (1 - total) * (1 - more) if balanced else total + more
            lost |= unsure
            j += 1
        return total, lost

    def trace(self, rays: _Rays, slots: int):
        """Colour, deepest generation and undecidedness of every slot; the primary hits; the number of rays."""
        film = [dr.zeros(mi.Float64, slots) for _ in range(3)]
        deepest, lost = dr.zeros(mi.UInt32, slots), dr.zeros(mi.UInt32, slots)
        primary, waves, count = None, [(0, rays)], 0
        while waves:
            generation, rays = waves.pop()
            count += dr.width(rays.slot)
            hit, color, unsure, secondary = self._interact(rays)
            last = generation == self.document.tracing.max_depth
            if last:  # beyond the last generation lies the background (decision D1)
                for _, weight, _ in secondary:
                    color += self.background * weight
            for k in range(3):
                dr.scatter_add(film[k], mi.Float64(color[k]) * mi.Float64(rays.weight), rays.slot)
            dr.scatter_reduce(dr.ReduceOp.Max, deepest, dr.opaque(mi.UInt32, generation), rays.slot)
            dr.scatter_reduce(dr.ReduceOp.Max, lost, dr.select(unsure, mi.UInt32(1), 0), rays.slot)
            dr.eval(film, deepest, lost, hit, secondary)
            primary = primary or hit
            if not last:
                waves += [(generation + 1, queue) for queue in self._queues(rays, hit, secondary)]
        return film, deepest, lost, primary, count

    def _interact(self, rays: _Rays):
        """First hits, their own colour or the background, and (direction, weight, sides) of the secondary rays."""
        hit = self.crossings.first_hit(rays.o, rays.d, rays.sides, rays.left, rays.weight > 0)
        pick = lambda column: dr.gather(mi.Float, column, hit.index, hit.met)
        R = pick(self.reflection)
        T = pick(self.transparency) if self.transparent else mi.Float(0)
        local = (1 - R) * (1 - T)
        light, unsure = self.illumination(hit, rays.sides, hit.met & (local > 0))
        color = dr.select(hit.met, mi.Color3f(*map(pick, self.color)) * light * local, self.background)
        secondary = []
        if self.shiny:
            cos1 = -dr.dot(rays.d, hit.normal)
            reflected = dr.normalize(rays.d + 2 * cos1 * hit.normal)
            weight = R * (1 - T)
            if self.transparent:
                # pairwise with air; the side tells which of the two is left (decision R1)
                n = pick(self.refractive_index)
                ratio = dr.select(rays.sides.test(hit.index), n, dr.rcp(n))  # n1 / n2
                cos2_squared = 1 - dr.square(ratio) * (1 - dr.square(cos1))
                total = cos2_squared < 0
                weight += dr.select(total, T, 0)  # total reflection keeps its weight (decision R3)
                refracted = (rays.d + hit.normal * cos1) * ratio - hit.normal * dr.safe_sqrt(cos2_squared)
                secondary.append((dr.normalize(refracted), dr.select(hit.met & ~total, T, 0),
                                  rays.sides.flipped(hit.index)))
            secondary.append((reflected, dr.select(hit.met, weight, 0), rays.sides))
        return hit, color, hit.lost | unsure, secondary

    def _queues(self, rays: _Rays, hit: MitsubaHit, secondary) -> list[_Rays]:
        """The secondary rays that have weight, all kinds together, in queues of at most MOST_RAYS."""
        chosen = [(*kind, found) for kind in secondary if dr.width(found := dr.compress(kind[1] > 0))]
        total = sum(dr.width(found) for *_, found in chosen)
        left = dr.maximum(rays.left - hit.t, 0) if self.document.tracing.range == "path" else rays.left  # F4, M5
        queues = []
        for start in range(0, total, MOST_RAYS):
            size = min(MOST_RAYS, total - start)
            # a queue of one ray would compile a kernel of its own: pad it with a ray of weight 0
            lane = dr.arange(mi.UInt32, max(size, 2)) + dr.opaque(mi.UInt32, start)
            queue = None
            for d, weight, sides, found in chosen:
                mine = lane < dr.opaque(mi.UInt32, dr.width(found))
                source = dr.gather(mi.UInt32, found, lane, mine)
                pick = lambda value: dr.gather(type(value), value, source, mine)
                direction = pick(d)
                theirs = _Rays(spawn(pick(hit.p), pick(hit.facet), direction, self.crossings.offset), direction,
                               Sides([pick(w) for w in sides.words]), pick(left), pick(rays.weight) * pick(weight),
                               pick(rays.slot))
                queue = dr.select(mine, theirs, queue) if queue else theirs
                lane -= dr.opaque(mi.UInt32, dr.width(found))  # wraps around for the lanes that are served
            dr.eval(queue)
            queues.append(queue)
        return queues

    # --- camera and picture ------------------------------------------------------------------------------------------
    def camera_difference(self) -> float | None:
        """The largest difference of a component between our directions and those of the converted sensor, if there is one."""
        if self.converted.sensor is None:
            return None
        ours = document_directions(self.document.camera, count=self.document.camera.width)
        return float(np.abs(pixel_directions(self.converted.sensor)[0] - ours).max())

    def _camera_rays(self, first: int, count: int, samples: int) -> _Rays:
        d = document_directions(self.document.camera, samples, first, count).astype(np.float32)
        if len(d) == 1:
            d = np.repeat(d, 2, axis=0)  # see `_queues`; the second ray has weight 0
        lane = dr.arange(mi.UInt32, len(d))
        width = lambda value: value + dr.zeros(type(value), len(d))
        weight = dr.select(lane < dr.opaque(mi.UInt32, count * samples**2), mi.Float(1), 0)
        slot = dr.minimum(lane // samples**2, dr.opaque(mi.UInt32, count - 1))
        rays = _Rays(width(mi.Point3f(*self.document.camera.position)), mi.Vector3f(d.T),
                     Sides([width(w) for w in self.sides.words]), width(self.max_distance), weight, slot)
        dr.eval(rays)
        return rays

    def picture(self):
        """All planes of a `Picture`, flat, and the number of rays."""
        camera, samples = self.document.camera, self.document.tracing.samples
        pixels, band = camera.width * camera.height, max(1, MOST_RAYS // self.document.tracing.samples**2)
        bands, rays = [], 0
        for first in range(0, pixels, band):
            count = min(band, pixels - first)
            film, deepest, lost, hit, traced = self.trace(self._camera_rays(first, count, samples), max(count, 2))
            if samples > 1:  # the geometry planes belong to the pixel's centre
                centre = self._camera_rays(first, count, 1)
                hit = self.crossings.first_hit(centre.o, centre.d, centre.sides, centre.left, centre.weight > 0)
                traced += count
            numpy = lambda array: array.numpy().T[:count]
            met = numpy(hit.met)
            at_hits = lambda plane: np.where(met[:, None], numpy(plane).astype(float), np.nan)
            bands.append({
                "color": np.stack([numpy(c) for c in film], axis=1) / samples**2, "t": numpy(hit.t).astype(float),
                "position": at_hits(hit.p), "normal": at_hits(hit.normal),
                "index": np.where(met, numpy(hit.index), -1).astype(np.int32),
                "depth": numpy(deepest).astype(np.uint8),
                "status": np.where(numpy(lost) > 0, UNDECIDED, np.where(met, HIT, MISS)).astype(np.uint8)})
            rays += traced
        return {name: np.concatenate([b[name] for b in bands]) for name in bands[0]}, rays
