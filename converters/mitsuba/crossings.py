"""Where rays cross the objects of a converted scene, and how much light gets through them.

Two things replace what fp32 and facets cannot give. A ray starts OFFSET away from its surface. And since the side of
every object is inherited (decision M3), a hit whose direction through the surface contradicts that side is no crossing:
it is the surface the ray just left, or the wrong side of a facet at grazing incidence, and the ray goes on behind it.
"""

from __future__ import annotations

from dataclasses import dataclass

from raytruth.reference_tracer.scene.model import Scene
from raytruth.reference_tracer.tracer.rays import Sides

from .refine import Refinement
from .scene import MitsubaScene
from .variant import dr, mi

OFFSET = 1.2e-7  # of 1 + the largest coordinate: a unit of fp32; Mitsuba's own, 9e-5, would dominate every error
MOST_REFUSED = 64  # hits on the wrong side in a row; beyond, the ray is undecided
MOST_CROSSINGS = 4096  # of one shadow ray


@dataclass
class MitsubaHit:
    """The first crossing of each ray."""

    t: object  # mi.Float, infinity where nothing was hit
    p: object  # mi.Point3f
    facet: object  # mi.Vector3f, unit normal of Mitsuba's geometry
    normal: object  # mi.Vector3f, unit, interpolated, turned against the ray (decision N1)
    index: object  # mi.UInt32, object in scene order
    met: object  # mi.Bool
    lost: object  # mi.Bool, undecided


def spawn(p, facet, d, offset: float = OFFSET):
    """A point off the facet through p, on the side that d points to; `offset` is relative to 1 + p's coordinates."""
    return p + facet * dr.copysign((1 + dr.max(dr.abs(p))) * offset, dr.dot(facet, d))


class MitsubaIntersector:
    """The queries of a tracer on a converted scene, for arrays of rays."""

    def __init__(self, scene: Scene, converted: MitsubaScene, offset: float = OFFSET, refined: bool = False):
        self.scene, self.offset = converted.scene, offset
        self.index_of_shape = mi.UInt32(converted.index_of_shape)
        # by how much each crossing dims light (decisions L3, F3)
        self.dimming = mi.Float([o.material.transparency if scene.casts_shadow(o) else 1.0 for o in scene.objects])
        meshes = {k: part.error for k, part in enumerate(converted.parts) if part.kind == "mesh" and part.error is not None}
        self.refinement = Refinement(scene.objects, meshes) if refined else None

    def _meet(self, o, d, limit, sides: Sides, active):
        """Mitsuba's next intersection, its place, whether there is one, its object, and whether it can be a crossing.

        The place is o + t d: Mitsuba's own, interpolated between corners, is off by 1e-5 on the rectangle of a plane.
        """
        ray = mi.Ray3f(o, d, limit, mi.Float(0), mi.Color0f())
        si = self.scene.ray_intersect(ray, mi.RayFlags.ShadingFrame, coherent=False, active=active)
        found = active & si.is_valid()
        index = dr.gather(mi.UInt32, self.index_of_shape, dr.reinterpret_array(mi.UInt32, si.shape), found)
        leaving = dr.dot(d, si.n) > 0
        return si, dr.fma(d, si.t, o), found, index, found & ~(leaving ^ sides.test(index))

    def first_hit(self, o, d, sides: Sides, limit, active) -> MitsubaHit:
        """The first crossing of each ray with any object within `limit` (decisions M5, F4)."""
        hit = self._first_hit(o, d, sides, limit, active)
        if self.refinement:
            hit.t, hit.p, hit.normal = self.refinement.refined(o, d, hit.t, hit.normal, hit.index, hit.met)
        # by the facet: at a rim the interpolated normal may point either way
        hit.normal = dr.select(dr.dot(d, hit.facet) > 0, -hit.normal, hit.normal)
        return hit

    @dr.syntax
    def _first_hit(self, o, d, sides: Sides, limit, active) -> MitsubaHit:
        """The same as Mitsuba has it, the normal out of the solid."""
        origin, passed, tries = mi.Point3f(o), mi.Float(0), mi.UInt32(0)
        t, p, facet, normal = mi.Float(dr.inf), mi.Point3f(o), mi.Vector3f(0), mi.Vector3f(0)
        index, met, searching = mi.UInt32(0), mi.Bool(False), mi.Bool(active)
        while searching:
            si, place, found, candidate, crossing = self._meet(origin, d, limit - passed, sides, searching)
            t = dr.select(crossing, passed + si.t, t)
            p = dr.select(crossing, place, p)
            facet = dr.select(crossing, mi.Vector3f(si.n), facet)
            normal = dr.select(crossing, mi.Vector3f(si.sh_frame.n), normal)
            index = dr.select(crossing, candidate, index)
            met |= crossing
            passed = dr.select(found, passed + si.t, passed)
            origin = dr.select(found, spawn(place, si.n, d, self.offset), origin)
            tries += 1
            searching = found & ~crossing & (tries < MOST_REFUSED)
        lost = active & ~met & (tries >= MOST_REFUSED)
        return MitsubaHit(t, p, facet, normal, index, met, lost)

    @dr.syntax
    def transmittance(self, o, d, distance, sides: Sides, active):
        """The part of a light that reaches o from `distance` away: transparency at every crossing (L3, F3)."""
        intensity = dr.select(active, mi.Float(1), 0)
        origin, passed, tries, searching = mi.Point3f(o), mi.Float(0), mi.UInt32(0), mi.Bool(active)
        words = Sides([mi.UInt64(w) for w in sides.words])
        while searching:
            si, place, found, index, crossing = self._meet(origin, d, distance - passed, words, searching)
            intensity *= dr.select(crossing, dr.gather(mi.Float, self.dimming, index, crossing), 1)
            words = Sides.select(crossing, words.flipped(index), words)
            passed = dr.select(found, passed + si.t, passed)
            origin = dr.select(found, spawn(place, si.n, d, self.offset), origin)
            tries += 1
            searching = found & (intensity > 0) & (tries < MOST_CROSSINGS)
        return intensity, tries >= MOST_CROSSINGS
