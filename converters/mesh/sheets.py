"""Exact parametric meshes of the two unbounded surfaces of the document: every vertex lies on the surface.

Marching cubes would spread its cells over all the space that rays can reach; parameters put them where they count.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from raytruth.reference_tracer.surfaces import Paraboloid, Plane

FLAT_CELLS = 64  # along each side of a plane: fp32 rounds a vertex by 6e-8 of its distance, so near ones must exist


@dataclass(frozen=True)
class Patch:
    """The square of a plane that holds everything a ray can reach, in the plane's own frame."""

    middle: np.ndarray  # (3,)
    u: np.ndarray  # (3,) unit, along one side
    v: np.ndarray  # (3,) unit, along the other; u x v is the normal, out of the solid
    half: float  # half the length of a side

    @property
    def clipped(self) -> str:
        return f"cut to a square of side {2 * self.half:.4g} that holds all a ray can reach"


def plane_patch(plane: Plane, box: np.ndarray) -> Patch | None:
    """The patch of `plane` that covers its part inside `box` (2, 3); None where the plane misses the ball around it."""
    normal = np.array([plane.a, plane.b, plane.c])
    normal /= np.linalg.norm(normal) * (-1 if plane.inside == "positive" else 1)
    middle, radius = 0.5 * (box[0] + box[1]), 0.5 * float(np.linalg.norm(box[1] - box[0]))
    height = middle @ normal
    if abs(height) > radius:
        return None
    # the side that is least along the normal makes the sides follow the axes where the plane does
    u = np.cross(normal, np.eye(3)[np.argmin(np.abs(normal))])
    u /= np.linalg.norm(u)
    return Patch(middle - height * normal, u, np.cross(normal, u), radius)


def plane_grid(patch: Patch) -> tuple[np.ndarray, np.ndarray]:
    """Vertices and faces of a flat grid over `patch`."""
    steps = np.linspace(-patch.half, patch.half, FLAT_CELLS + 1)
    s, t = np.meshgrid(steps, steps, indexing="ij")
    vertices = patch.middle + s.ravel()[:, None] * patch.u + t.ravel()[:, None] * patch.v
    return vertices, _grid_faces(FLAT_CELLS)


def paraboloid_grid(paraboloid: Paraboloid, box: np.ndarray, rings: int) -> tuple[np.ndarray, np.ndarray, float] | None:
    """Vertices, faces and height of the part of `paraboloid` up to the top of its part inside `box` (2, 3).

    x = a rho cos(phi), y = b rho sin(phi), z = rho^2, with `rings` steps of rho and three times as many of phi. None
    where the box lies below the apex.
    """
    far = np.abs(box).max(axis=0)
    height = min(box[1, 2], (far[0] / paraboloid.a) ** 2 + (far[1] / paraboloid.b) ** 2)
    if height <= 0:
        return None
    sectors = 3 * rings
    # a step d of rho lies d^2 / 4 off in z and, where the slope is s, d^2 / 4 / sqrt(1 + s^2) off the surface: steps
    # that grow with (1 + s^2)^(1/4) spread the error evenly
    fine = np.linspace(0, np.sqrt(height), 8192)
    steps = np.cumsum((1 + (2 * fine / max(paraboloid.a, paraboloid.b)) ** 2) ** -0.25)
    rho = np.interp(np.linspace(steps[0], steps[-1], rings + 1)[1:], steps, fine)
    phi = 2 * np.pi * np.arange(sectors) / sectors
    x = paraboloid.a * np.outer(rho, np.cos(phi))
    y = paraboloid.b * np.outer(rho, np.sin(phi))
    z = (x / paraboloid.a) ** 2 + (y / paraboloid.b) ** 2
    vertices = np.concatenate([[np.zeros(3)], np.stack([x, y, z], axis=-1).reshape(-1, 3)])
    around = np.arange(sectors)
    ahead = np.roll(around, -1)
    fan = np.stack([np.zeros_like(around), ahead + 1, around + 1], axis=1)
    inner = 1 + np.arange(rings - 1)[:, None] * sectors
    a, b, c, d = ((inner + k).ravel() for k in (around, ahead, around + sectors, ahead + sectors))
    faces = np.concatenate([fan, np.stack([a, b, c], axis=1), np.stack([b, d, c], axis=1)])
    # these run clockwise seen from below, which is outside of z > rho^2 (decision O2)
    return vertices, faces if paraboloid.inside == "negative" else faces[:, ::-1], height


def _grid_faces(cells: int) -> np.ndarray:
    """(2 cells^2, 3): the triangles of a square grid whose vertices are numbered row by row."""
    i, j = np.meshgrid(np.arange(cells), np.arange(cells), indexing="ij")
    row = cells + 1
    a = (i * row + j).ravel()
    b, c, d = a + row, a + 1, a + row + 1
    return np.concatenate([np.stack([a, b, c], axis=1), np.stack([b, d, c], axis=1)])
