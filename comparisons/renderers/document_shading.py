"""Sections 4.3.1 to 4.3.4 in NumPy fp64, on crossings that another tracer finds: Embree on meshes, raysect on its primitives.

Written from the document and its decisions, and sharing no shading code with the reference or with Mitsuba's renderer.
The law of refraction is always Snell's (decision E1).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from raytruth.converters.crossings import Crossings, Start
from raytruth.reference_tracer.scene.model import Scene
from raytruth.reference_tracer.scene.placement import is_inside
from raytruth.reference_tracer.tracer.camera import canvas_point, frame
from raytruth.reference_tracer.tracer.render import HIT, MISS, UNDECIDED, Picture

MOST_RAYS = 1 << 16  # of one wave: its arrays stay in the processor's cache


def traced(scene: Scene, crossings: Crossings) -> tuple[Picture, int]:
    """The picture of `scene`, without metadata, and the number of rays it took."""
    planes, rays = _Tracer(scene, crossings).picture()
    camera = scene.camera
    return Picture(scene=scene, **{name: plane.reshape(camera.height, camera.width, *plane.shape[1:])
                                   for name, plane in planes.items()}), rays


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
    """A scene bound to whoever finds hits on it."""

    def __init__(self, scene: Scene, crossings: Crossings):
        self.scene, self.crossings = scene, crossings
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
