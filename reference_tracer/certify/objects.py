"""Questions to single objects of a World, for many rays at once."""

from __future__ import annotations

from collections.abc import Iterator

import drjit as dr
import numpy as np

from ..numbers import OutwardInterval
from ..tracer.families import Family, Member
from ..tracer.rays import Hit, Ray, Sides
from ..tracer.world import World
from .records import SHADOW, numpy


def one_by_one(world: World) -> Iterator[tuple[int, Family, Member]]:
    """Every object of the world with its family, in scene order."""
    places = sorted((index, row, family) for family in world.families for row, index in enumerate(family.indices))
    for index, row, family in places:
        yield index, family, family.member(world.arrays.count(row))


class Radius:
    """How far from t a crossing provably lies (first_hit.Proof.radius), for hits of any object.

    `proofs` is a World whose method is "proof".
    """

    def __init__(self, proofs: World):
        self.world = proofs
        UInt = proofs.arrays.UInt
        self.rows = []  # one table a family: the row of every object, or no_row
        self.no_row = max(len(f.indices) for f in proofs.families)
        for family in proofs.families:
            row = {index: j for j, index in enumerate(family.indices)}
            # one entry more than there are objects, for rays that met none
            self.rows.append(UInt([row.get(k, self.no_row) for k in range(proofs.object_count + 1)]))
        dr.make_opaque(self.rows)

    def of(self, ray: Ray, hit: Hit):
        """The radius of every hit (Float): infinity where none is shown, 0 where nothing was hit."""
        arrays = self.world.arrays
        result = dr.zeros(arrays.Float, dr.width(hit.t))
        for family, rows in zip(self.world.families, self.rows):
            row = dr.gather(arrays.UInt, rows, hit.index)
            here = row != self.no_row
            member = family.member(dr.select(here, row, 0), here)
            t = dr.select(here, hit.t, 1)
            own = family.method.radius(member.solid, member.local(ray.o, ray.d), t, here)
            result = dr.select(here, own, result)
        return result


def rivals(proofs: World, ray: Ray, hit: Hit, radius):
    """Whether another object may be crossed within `radius` of a hit, so that which is first is not proven (Bool)."""
    arrays = proofs.arrays
    low, high = dr.maximum(hit.t - 2 * radius, 0), hit.t + 2 * radius
    met = hit.index < proofs.object_count
    close = arrays.UInt(0)
    for family in proofs.families:
        close = _close_in(proofs, family, ray, dr.select(met, low, 0), dr.select(met, high, 0), close)
    return met & (close > 1)


@dr.syntax
def _close_in(proofs: World, family: Family, ray: Ray, low, high, close):
    UInt = proofs.arrays.UInt
    j = UInt(0)
    while j < family.count:
        member = family.member(j)
        g, _ = member.solid.enclose(member.local(ray.o, ray.d), low, high, OutwardInterval)
        close += dr.select(g.excludes_zero(), UInt(0), 1)
        j += 1
    return close


def ray_of(world: World, rows: np.ndarray) -> Ray:
    """The rays of a table (records.py) as arrays of `world`."""
    arrays = world.arrays
    vector = lambda v: arrays.Vector(*(arrays.Float(v[:, k].copy()) for k in range(3)))
    return Ray(vector(rows["o"]), vector(rows["d"]),
               Sides([arrays.Bits(rows["sides"][:, k].copy()) for k in range(rows["sides"].shape[1])]),
               arrays.Float(rows["limit"].copy()))


def local_rays(world: World, rows: np.ndarray) -> np.ndarray:
    """(objects, n, 2, 3) origin and direction of every ray in every object's own frame, as the kernels compute them."""
    ray, found = ray_of(world, rows), []
    for _, _, member in one_by_one(world):
        local = member.local(ray.o, ray.d)
        found.append(np.stack([numpy(local.o, len(rows)), numpy(local.d, len(rows))], axis=1))
    return np.stack(found)


def crossings_of(world: World, rows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(objects, n) how often the world's method sees each ray cross each object, and whether it is undecided.

    For first hits the count stops at 1, for shadow rays behind the first crossing of an opaque object.
    """
    arrays, ray = world.arrays, ray_of(world, rows)
    limit, counts, unsure = arrays.Float(rows["limit"].copy()), [], []
    shadow = arrays.Bool((rows["kind"] == SHADOW).copy())
    for index, family, member in one_by_one(world):
        only_first = ~shadow | (world.scene.objects[index].material.transparency == 0)
        count, undecided = family.method.crossings(member.solid, member.local(ray.o, ray.d),
                                                   ray.sides.test(member.index), limit, only_first)
        counts.append(numpy(count, len(rows)))
        unsure.append(numpy(undecided, len(rows)))
    return np.stack(counts), np.stack(unsure)
