"""Embree on a scene: Embree finds the intersections with meshes, and sections 4.3.1 to 4.3.4 are evaluated on them.

A second tracer on the meshes that Mitsuba is given: where the two agree, what is left is the meshes' error. Written
from the document and its decisions, in NumPy fp64, and sharing no shading code with the reference or with Mitsuba's
renderer. The law of refraction is always Snell's (decision E1).
"""

from __future__ import annotations

import time
from dataclasses import dataclass
from importlib.metadata import version

import numpy as np

from converters.embree import EmbreeIntersector, EmbreeScene, convert
from converters.embree.crossings import Start
from converters.mesh import largest
from reference_tracer.scene.model import Scene
from reference_tracer.scene.placement import is_inside
from reference_tracer.tracer.camera import canvas_point, frame
from reference_tracer.tracer.render import HIT, MISS, UNDECIDED, Picture

MOST_RAYS = 1 << 16  # of one wave: its arrays stay in the processor's cache


def render(scene: Scene, *, resolution: int = 256) -> Picture:
    """The picture of `scene` on meshes of `resolution` cells along their longest side.

    Raises InputError for impossible meshes, MissingError without embreex.
    """
    converted = convert(scene, resolution)
    start, cpu = time.perf_counter(), time.process_time()
    planes, rays = _Tracer(scene, converted).picture()
    seconds, cpu = time.perf_counter() - start, time.process_time() - cpu
    camera = scene.camera
    picture = Picture(scene=scene, **{name: plane.reshape(camera.height, camera.width, *plane.shape[1:])
                                      for name, plane in planes.items()})
    solids = [(k, solid) for k, solid in enumerate(converted.solids) if solid]
    picture.metadata = {
        "scene": scene.name, "scene_hash": scene.hash, "renderer": "embree", "embreex": version("embreex"),
        "resolution": resolution, "triangles": converted.triangles,
        "measured_mesh_error": largest(solid.error for _, solid in solids), "precision": 32,
        "errors": [solid.error if solid else 0.0 for solid in converted.solids],
        "tilts": [solid.tilt if solid else 0.0 for solid in converted.solids],
        "clipped": "; ".join(f"object {k}: {solid.clipped}" for k, solid in solids if solid.clipped),
        "rays": rays, "undecided pixels": int(np.sum(picture.status == UNDECIDED)),
        # nothing is compiled: the first is a warm one
        "build": converted.seconds, "first": seconds, "warm": seconds, "cpu": cpu}
    return picture


@dataclass
class _Rays:
    """n rays of one generation; `weight` is each one's share in the colour of pixel `slot`."""

    start: Start
    d: np.ndarray  # (n, 3) unit
    inside: np.ndarray  # (n, objects)
    left: np.ndarray  # each one's range
    weight: np.ndarray
    slot: np.ndarray

    def __len__(self) -> int:
        return len(self.d)

    def of(self, which) -> _Rays:
        return _Rays(self.start.of(which), self.d[which], self.inside[which], self.left[which], self.weight[which],
                     self.slot[which])


@dataclass
class _Film:
    """What a band of pixels gathers."""

    color: np.ndarray  # (pixels, 3)
    deepest: np.ndarray  # generation
    lost: np.ndarray
    rays: int = 0

    def add(self, slot, color) -> None:
        for k in range(3):
            self.color[:, k] += np.bincount(slot, color[:, k], len(self.color))


class _Tracer:
    """A scene bound to its conversion."""

    def __init__(self, scene: Scene, converted: EmbreeScene):
        self.scene, self.crossings = scene, EmbreeIntersector(scene, converted)
        column = lambda name: np.array([getattr(obj.material, name) for obj in scene.objects])
        self.color = column("color").reshape(-1, 3)
        self.R, self.T, self.n = column("reflection"), column("transparency"), column("refractive_index")
        self.sides = np.array([is_inside(obj, scene.camera.position) for obj in scene.objects], bool)
        self.background = np.array(scene.background)
        self.shadows, self.reflections, self.refractions = (
            effect in scene.tracing.effects for effect in ("shadow", "reflection", "refraction"))

    def illumination(self, p, hit_index, facet, normal, inside):
        """Section 4.3.1: the lights' cos(phi) * brightness * intensity, together (L1 to L3, F1, F2), and doubts."""
        total, lost = np.full_like(p, self.scene.tracing.ambient), np.zeros(len(p), bool)
        for light in self.scene.lights:
            way = np.array(light.position) - p
            distance = np.linalg.norm(way, axis=1)
            with np.errstate(invalid="ignore"):  # a point that the light sits on is not lit
                shadow_dir = way / distance[:, None]
                cos = _dot(shadow_dir, normal)
            lit = np.flatnonzero(cos > 0)
            intensity = np.ones(len(lit))
            if self.shadows:
                start = Start(p[lit], hit_index[lit], facet[lit])
                intensity, unsure = self.crossings.transmittance(start, shadow_dir[lit], distance[lit], inside[lit])
                lost[lit] |= unsure
            more = (cos[lit] * intensity)[:, None] * np.array(light.brightness)
            total[lit] = (1 - (1 - total[lit]) * (1 - more) if self.scene.tracing.lights == "balanced" else total[lit] + more)
        return total, lost

    def trace(self, rays: _Rays, film: _Film):
        """Follows the rays to the last generation, gathering on `film`; returns the first hits."""
        primary, waves = None, [(0, rays)]
        while waves:
            generation, rays = waves.pop()
            film.rays += len(rays)
            hit, secondary = self._interact(rays, film)
            film.deepest[rays.slot] = np.maximum(film.deepest[rays.slot], generation)
            primary = primary or hit
            if generation == self.scene.tracing.max_depth:  # beyond it lies the background (decision D1)
                film.add(secondary.slot, secondary.weight[:, None] * self.background)
            else:
                waves += [(generation + 1, secondary.of(slice(first, first + MOST_RAYS)))
                          for first in range(0, len(secondary), MOST_RAYS)]
        return primary

    def _interact(self, rays: _Rays, film: _Film):
        """First hits, whose own colour or background goes to the film, and the secondary rays that have weight."""
        hit = self.crossings.first_hit(rays.start, rays.d, rays.inside, rays.left)
        film.lost[rays.slot[hit.lost]] = True
        missed, met = np.flatnonzero(hit.index < 0), np.flatnonzero(hit.index >= 0)
        film.add(rays.slot[missed], rays.weight[missed, None] * self.background)
        k, d, normal, facet = hit.index[met], rays.d[met], hit.normal[met], hit.facet[met]
        p = rays.start.o[met] + hit.t[met, None] * d
        here, weight, inside = rays.slot[met], rays.weight[met], rays.inside[met]
        R, T = self.R[k], self.T[k]

        own = np.flatnonzero((1 - R) * (1 - T) > 0)
        light, unsure = self.illumination(p[own], k[own], facet[own], normal[own], inside[own])
        film.lost[here[own[unsure]]] = True
        share = ((1 - R) * (1 - T) * weight)[own]
        film.add(here[own], self.color[k[own]] * light * share[:, None])

        cos1 = -_dot(d, normal)
        leaving = inside[np.arange(len(k)), k]
        ratio = np.where(leaving, self.n[k], 1 / self.n[k])  # n1 / n2, pairwise with air (decision R1)
        sin2_squared = ratio**2 * (1 - cos1**2)
        total = (sin2_squared > 1) & (T > 0)
        # mixing, section 4.3.4; total reflection keeps the weight of refraction (decision R3)
        mirrored, transmitted = R * (1 - T) * self.reflections, T * self.refractions
        untraced = R * (1 - T) * (not self.reflections) + T * (not self.refractions)
        if untraced.any():  # a kind of ray that is left out sees the background
            film.add(here, (weight * untraced)[:, None] * self.background)
        reflected, refracted = mirrored + np.where(total, transmitted, 0), np.where(total, 0, transmitted)
        start = Start(p, k, facet)
        mirror = np.flatnonzero(reflected > 0)
        through = np.flatnonzero(refracted > 0)
        across = inside[through]
        across[np.arange(len(through)), k[through]] ^= True
        reflection_dir = _unit(d[mirror] + 2 * cos1[mirror, None] * normal[mirror])
        bent, cos2 = ratio[through, None], np.sqrt(1 - sin2_squared[through])[:, None]
        refraction_dir = _unit((d[through] + normal[through] * cos1[through, None]) * bent - normal[through] * cos2)
        both = np.concatenate([mirror, through])
        left = rays.left[met]
        if self.scene.tracing.range == "path":  # decision F4
            left = np.maximum(left - hit.t[met], 0)
        return hit, _Rays(start.of(both), np.concatenate([reflection_dir, refraction_dir]),
                          np.concatenate([inside[mirror], across]), left[both],
                          np.concatenate([(weight * reflected)[mirror], (weight * refracted)[through]]), here[both])

    def _camera_rays(self, first: int, count: int, samples: int) -> _Rays:
        """Section 2: the rays through pixels [first, first + count) in row order, n x n a pixel (decision C2)."""
        f = frame(self.scene.camera)
        lane = np.arange(count * samples**2)
        slot, sample = np.divmod(lane, samples**2)
        row, col = np.divmod(first + slot, f.width)
        x, y = canvas_point(f, row, col, sample // samples, sample % samples, samples)
        d = _unit(x[:, None] * f.v_x + y[:, None] * f.v_y + f.v_dir)
        start = Start(np.broadcast_to(f.v_pos, d.shape), np.full(len(d), -1), np.zeros(d.shape))
        return _Rays(start, d, np.broadcast_to(self.sides, (len(d), len(self.sides))),
                     np.full(len(d), self.scene.tracing.max_distance), np.ones(len(d)), slot)

    def picture(self):
        """All planes of a `Picture`, flat, and the number of rays."""
        camera, samples = self.scene.camera, self.scene.tracing.samples
        pixels, band = camera.width * camera.height, max(1, MOST_RAYS // samples**2)
        bands, traced = [], 0
        for first in range(0, pixels, band):
            count = min(band, pixels - first)
            film = _Film(np.zeros((count, 3)), np.zeros(count, np.uint8), np.zeros(count, bool))
            centre = rays = self._camera_rays(first, count, samples)
            hit = self.trace(rays, film)
            if samples > 1:  # the geometry planes belong to the pixel's centre
                centre = self._camera_rays(first, count, 1)
                hit = self.crossings.first_hit(centre.start, centre.d, centre.inside, centre.left)
                film.rays += count
            met = (hit.index >= 0)[:, None]
            position = centre.start.o + np.where(met, hit.t[:, None], np.nan) * centre.d
            bands.append({"color": film.color / samples**2, "t": hit.t, "position": position,
                          "normal": np.where(met, hit.normal, np.nan), "index": hit.index.astype(np.int32),
                          "depth": film.deepest,
                          "status": np.where(film.lost, UNDECIDED, np.where(met[:, 0], HIT, MISS)).astype(np.uint8)})
            traced += film.rays
        return {name: np.concatenate([b[name] for b in bands]) for name in bands[0]}, traced


def _dot(a, b):
    return np.einsum("ij,ij->i", a, b)


def _unit(v):
    return v / np.linalg.norm(v, axis=1, keepdims=True)
