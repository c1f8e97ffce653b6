"""Where rays cross the meshes of a converted scene, and how much light gets through them.

The side of every object is inherited (decision M3), so a hit whose direction through its facet contradicts that side is
no crossing: it is the facet the ray just left, or one seen from its wrong side where the interpolated normal and the
facet's disagree. The ray then goes on behind it. Only against the object it left does a ray start off its surface;
distances are always those of the undisplaced ray.
"""

from __future__ import annotations

import numpy as np

from raytruth.converters.crossings import Hit, Start
from raytruth.reference_tracer.scene.model import Scene

from .scene import EmbreeScene, Solid

MOST_REFUSED = 64  # hits on the wrong side in a row; beyond, the ray is undecided
MOST_CROSSINGS = 4096  # of one shadow ray with one object


class EmbreeIntersector:
    """The queries of a tracer on a converted scene, for arrays of rays."""

    def __init__(self, scene: Scene, converted: EmbreeScene):
        self.solids = [(k, solid) for k, solid in enumerate(converted.solids) if solid]
        self.dimming = [(k, solid) for k, solid in self.solids if scene.casts_shadow(scene.objects[k])]
        self.transparency = np.array([obj.material.transparency for obj in scene.objects])

    def first_hit(self, start: Start, d, inside, reach) -> Hit:
        """The first crossing of each ray with any object within `reach` (decisions M5, F4); `inside` is (n, objects)."""
        count = len(d)
        t, index, triangle = np.full(count, np.inf), np.full(count, -1), np.zeros(count, int)
        lost = np.zeros(count, bool)
        for k, solid in self.solids:
            limit = np.minimum(t, reach)
            for ray, distance, met, crossing in self._hits(k, solid, start, d, limit, inside[:, k], lost):
                found = ray[crossing]
                t[found], index[found], triangle[found] = distance[crossing], k, met[crossing]
        facet, normal = np.zeros((count, 3)), np.zeros((count, 3))
        for k, solid in self.solids:
            here = np.flatnonzero(index == k)
            if len(here):
                facet[here] = solid.facets[triangle[here]]
                normal[here] = solid.normal(start.o[here] + t[here, None] * d[here], triangle[here])
        # by the facet: at a rim the interpolated normal may point either way
        against = np.einsum("ij,ij->i", d, facet) > 0
        normal[against] *= -1
        return Hit(t, index, facet, normal, lost)

    def _hits(self, k: int, solid: Solid, start: Start, d, limit, inside, lost):
        """Rounds of (ray, t, triangle, whether it is a crossing), until each ray has crossed object k or met no more."""
        waiting, origin = np.arange(len(d)), self._origins(k, solid, start, d)
        for _ in range(MOST_REFUSED):
            if not len(waiting):
                return
            ray, t, triangle, slope = _next(solid, origin, start.o, d, limit, waiting)
            crossing = (slope > 0) == inside[ray]
            yield ray, t, triangle, crossing
            waiting = ray[~crossing]
            origin = self._onward(solid, start, d, t, triangle, ray, ~crossing)
        lost[waiting] = True

    def transmittance(self, start: Start, d, distance, inside):
        """The part of a light that arrives from `distance` away: transparency at every crossing (L3, F3).

        And whether that is undecided. All arrays hold one entry a ray.
        """
        intensity, lost = np.ones(len(d)), np.zeros(len(d), bool)
        for k, solid in self.dimming:
            waiting = np.flatnonzero(intensity > 0)
            side, origin = inside[:, k].copy(), self._origins(k, solid, start, d)[waiting]
            for _ in range(MOST_CROSSINGS):
                if not len(waiting):
                    break
                ray, t, triangle, slope = _next(solid, origin, start.o, d, distance, waiting)
                crossing = (slope > 0) == side[ray]
                through = ray[crossing]
                intensity[through] *= self.transparency[k]
                side[through] ^= True
                onward = intensity[ray] > 0
                waiting = ray[onward]
                origin = self._onward(solid, start, d, t, triangle, ray, onward)
            lost[waiting] = True
        return intensity, lost

    @staticmethod
    def _origins(k: int, solid: Solid, start: Start, d):
        leaving = start.left == k
        if not leaving.any():
            return start.o
        origin = start.o.copy()
        origin[leaving] = solid.behind(start.o[leaving], d[leaving], start.facet[leaving])
        return origin

    @staticmethod
    def _onward(solid: Solid, start: Start, d, t, triangle, ray, which):
        rays = ray[which]
        return solid.behind(start.o[rays] + t[which, None] * d[rays], d[rays], solid.facets[triangle[which]])


def _next(solid: Solid, origin, o, d, limit, waiting):
    """(ray, t, triangle, slope) of the `waiting` rays that meet a triangle before their limit, seen from `origin`."""
    found, triangle = solid.meet(origin, d[waiting])
    ray = waiting[found]
    t, slope = solid.distance(o[ray], d[ray], triangle)
    near = t < limit[ray]
    return ray[near], t[near], triangle[near], slope[near]
