"""A scene as raysect's primitives: closed forms in double precision, written by others (BSD-3; `pip install raysect`).

An unbounded surface becomes a solid that ends beyond all a ray can reach. raysect is asked ray by ray, in Python.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from raytruth.reference_tracer.errors import MissingError, UnsupportedError
from raytruth.reference_tracer.scene.model import Object, Scene
from raytruth.reference_tracer.scene.placement import corners, reach_in_frame, rotation_matrix
from raytruth.reference_tracer.surfaces import Clipped, Ellipsoid, Paraboloid, Plane, Sphere, Surface, Torus

from .crossings import Hit, Start

try:
    from raysect.core import AffineMatrix3D, Point3D, Ray, Vector3D
    from raysect.optical import World
    from raysect.primitive import Box, Intersect, Parabola, Subtract, Torus as Ring, Sphere as Ball  # isort: skip
except ImportError:
    World = None

# of (R + r)^5 / (R r)^2, how digits of a quartic's coefficients move a torus: how far its roots lie from it at most. One ray in
# 25 000 comes near; measured by tests/comparisons/test_raysect.py
QUARTIC = 3e-12
MOST_CROSSINGS = 4096  # of one ray with one object; beyond, it is undecided


class Solid:
    """One object: raysect's primitive at its place, and a ball around it."""

    def __init__(self, obj: Object, scene: Scene, world):
        """Raises UnsupportedError where raysect has no primitive for the surface."""
        self.complement = obj.surface.inside == "positive"
        within = reach_in_frame(scene, obj)
        placed = np.eye(4)
        placed[:3, :3], placed[:3, 3] = rotation_matrix(obj.rotation), obj.surface.center
        self.primitive = _primitive(obj.surface, within, placed, world, obj.name)
        box = obj.surface.box()
        self.middle, self.radius = None, np.inf
        if box is not None:
            around = corners(box) @ placed[:3, :3].T + placed[:3, 3]
            self.middle = around.mean(axis=0)
            self.radius = float(np.linalg.norm(around - self.middle, axis=1).max()) * (1 + 1e-9)

    def near(self, o, d) -> tuple[np.ndarray, np.ndarray]:
        """(k,): the rays that may meet the object, and how far along each raysect is asked from: a root found from afar has
        lost digits, of a torus with the fourth power of the distance."""
        if self.primitive is None:
            return np.zeros(0, int), np.zeros(0)
        if self.middle is None:
            return np.arange(len(d)), np.zeros(len(d))
        to_middle = self.middle - o
        along = np.einsum("ij,ij->i", to_middle, d)
        away = to_middle - along[:, None] * d
        may = np.flatnonzero((np.einsum("ij,ij->i", away, away) <= self.radius**2) & (along > -self.radius))
        return may, np.maximum(along[may] - self.radius, 0)

    def crossings(self, o: list, d: list, ahead: float, inside: bool, end: float) -> Iterator:
        """(distance, raysect's intersection) where one ray crosses the object, in order, up to a distance of `end`.

        raysect is asked from `ahead` on. Where the ray leaves the solid though it is not inside, or enters it though it is, it
        only meets the surface that it starts on. Raises OverflowError beyond MOST_CROSSINGS.
        """
        o = [p + ahead * v for p, v in zip(o, d)]
        found, tries = self.primitive.hit(Ray(Point3D(*o), Vector3D(*d), max(end - ahead, 0.0))), 0
        while found is not None and ahead + found.ray_distance < end:
            if (found.exiting != self.complement) == inside:
                yield ahead + found.ray_distance, found
                inside = not inside
            if (tries := tries + 1) > MOST_CROSSINGS:
                raise OverflowError
            found = self.primitive.next_intersection()


class RaysectIntersector:
    """The queries of a tracer on a scene (see `Crossings`). Rays start on surfaces: sides alone tell their roots apart."""

    def __init__(self, scene: Scene):
        """Raises MissingError without raysect, UnsupportedError for a surface that it has no primitive for."""
        if World is None:
            raise MissingError("raysect is not installed; it is optional ('pip install raysect' brings it)")
        self.world = World()  # whoever holds a primitive holds its world: it is not held by them
        self.solids = [Solid(obj, scene, self.world) for obj in scene.objects]
        self.transparency = [obj.material.transparency if scene.casts_shadow(obj) else 1.0 for obj in scene.objects]

    def first_hit(self, start: Start, d, inside, reach) -> Hit:
        """The first crossing of each ray with any object within `reach` (decisions M5, F4)."""
        count, lost = len(d), np.zeros(len(d), bool)
        o, v, end, index, normal = start.o.tolist(), d.tolist(), reach.tolist(), [-1] * count, [(0.0,) * 3] * count
        for k, solid in enumerate(self.solids):
            side = inside[:, k].tolist()
            for ray, ahead in zip(*(a.tolist() for a in solid.near(start.o, d))):
                try:
                    crossing = next(solid.crossings(o[ray], v[ray], ahead, side[ray], end[ray]), None)
                except OverflowError:
                    lost[ray] = True
                    continue
                if crossing is not None:
                    end[ray], found = crossing
                    n = found.normal.transform(found.primitive_to_world)
                    index[ray], normal[ray] = k, (n.x, n.y, n.z)
        index, facet = np.array(index, int), np.array(normal).reshape(-1, 3)
        met, complement = index >= 0, np.array([solid.complement for solid in self.solids])
        facet[met] /= np.linalg.norm(facet[met], axis=1, keepdims=True)
        facet[met & complement[index]] *= -1
        against = np.einsum("ij,ij->i", d, facet) > 0
        return Hit(np.where(met, end, np.inf), index, facet, np.where(against[:, None], -facet, facet), lost)

    def transmittance(self, start: Start, d, distance, inside):
        """The part of a light that arrives from `distance` away (decision L3), and whether that is undecided."""
        intensity, lost = np.ones(len(d)), np.zeros(len(d), bool)
        o, v, end = start.o.tolist(), d.tolist(), distance.tolist()
        for k, solid in enumerate(self.solids):
            side = inside[:, k].tolist()
            for ray, ahead in zip(*(a.tolist() for a in solid.near(start.o, d))):
                if intensity[ray] > 0:
                    try:
                        intensity[ray] *= self.transparency[k] ** sum(
                            1 for _ in solid.crossings(o[ray], v[ray], ahead, side[ray], end[ray]))
                    except OverflowError:
                        lost[ray] = True
        return intensity, lost


def error(surface: Surface) -> float:
    """How far raysect's hits lie from `surface` at most, beyond rounding."""
    own = surface.of if isinstance(surface, Clipped) else surface
    return QUARTIC * (own.R + own.r) ** 5 / (own.R * own.r) ** 2 if isinstance(own, Torus) else 0.0


def _primitive(surface: Surface, within: np.ndarray, placed: np.ndarray, parent, name: str):
    """`surface`, in a frame of its own that `placed` (4, 4) takes into that of `parent`; None where no ray reaches it.

    `within` (2, 3) is the box, in the surface's frame, that holds all a ray can reach."""
    match surface:
        case Sphere() as s:
            return Ball(s.r, parent, _affine(placed))
        case Ellipsoid() as s:
            return Ball(1.0, parent, _affine(placed @ np.diag([s.a, s.b, s.c, 1.0])))
        case Torus() as s if s.r < s.R:  # a tube that overlaps itself has an inner sheet there (decision O4)
            return Ring(s.R, s.r, parent, _affine(placed))
        case Paraboloid() as s:
            height = float(within[1, 2]) + 1.0
            if height <= 0:
                return None
            turn = np.diag([s.a, -s.b, -1.0, 1.0])  # theirs opens downwards from its apex at the height
            turn[2, 3] = height
            return Parabola(np.sqrt(height), height, parent, _affine(placed @ turn))
        case Plane() as s:
            normal = np.array([s.a, s.b, s.c]) / np.linalg.norm([s.a, s.b, s.c])
            middle, radius = within.mean(axis=0), float(np.linalg.norm(within[1] - within[0])) / 2
            height = middle @ normal
            side = 2 * (radius + abs(height)) + 1.0
            u = np.cross(normal, np.eye(3)[np.argmin(np.abs(normal))])
            u /= np.linalg.norm(u)
            face = np.eye(4)
            face[:3, :3], face[:3, 3] = np.stack([u, np.cross(normal, u), normal], axis=1), middle - height * normal
            return Box(Point3D(-side, -side, -side), Point3D(side, side, 0.0), parent, _affine(placed @ face))
        case Clipped() as s:
            whole = _primitive(s.of, np.array(s.clip.corners), np.eye(4), None, name)
            box = Box(Point3D(*s.clip.low), Point3D(*s.clip.high))
            if whole is None:
                return None if s.of.inside == "negative" else Box(Point3D(*s.clip.low), Point3D(*s.clip.high), parent,
                                                                  _affine(placed))
            joined = Intersect(whole, box) if s.of.inside == "negative" else Subtract(box, whole)
            joined.parent, joined.transform = parent, _affine(placed)
            return joined
    raise UnsupportedError(f"raysect has no primitive for {name or surface.type}, a {surface.type}"
                           + (" that overlaps itself" if isinstance(surface, Torus) else ""))


def _affine(matrix: np.ndarray):
    return AffineMatrix3D(matrix.tolist())
