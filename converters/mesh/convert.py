"""From an object of a scene to its mesh: at a given resolution, or as fine as a stated error asks and no finer."""

from __future__ import annotations

import json
import math
import time
from collections import OrderedDict
from typing import Protocol

import numpy as np

from raytruth.reference_tracer.errors import InputError
from raytruth.reference_tracer.scene.model import Object, Scene
from raytruth.reference_tracer.scene.placement import reach_in_frame
from raytruth.reference_tracer.surfaces import Paraboloid, Plane

from .error import kept, of_normals, of_triangles, worst
from .marching import march
from .mesh import Mesh
from .occupied import tight_box
from .placed import Placed
from .project import normals_at, project
from .sheets import paraboloid_grid, plane_grid, plane_patch

COARSE = 32  # resolution of the first guess of `mesh_to_error`
COARSEST = 4
SPARE = 1.02  # asked of a prediction beyond what the law says, so that few need a second
EXACT = 1e-6  # a mesh this far below the stated error is flat or empty, and no resolution changes it
MOST_ROUNDS = 12
MEASURED = 100_000  # triangles, the most curved ones, where no error is asked for
MOST_KEPT = 1 << 28  # bytes of meshes that a process keeps for the next scene


class Shelf(Protocol):
    """Where meshes outlast this process, by what they are made of."""

    def take(self, made_of: str) -> Mesh | None: ...
    def put(self, made_of: str, mesh: Mesh) -> None: ...


shelf: Shelf | None = None  # there is none, unless who runs this process sets one
_kept: OrderedDict[str, Mesh] = OrderedDict()  # by what they are made of, the last used at the end


def mesh_object(obj: Object, scene: Scene, resolution: int = 256) -> Mesh:
    """`obj` of `scene` as a mesh of `resolution` cells along its longest side (a paraboloid: rings; a plane: exact).

    Raises InputError for a resolution too coarse to hold a surface or too fine for the memory.
    """
    require_settings(resolution)
    placed = Placed(obj)
    # scenes that differ in light and material have their meshes in common
    within = None if placed.region is not None else reach_in_frame(scene, obj).tolist()
    key = json.dumps([obj.model_dump(mode="json", include={"surface", "rotation"}), within, resolution], sort_keys=True)
    if key not in _kept:
        found = shelf.take(key) if shelf else None
        _kept[key] = found or _made(placed, scene, resolution)
        if shelf and not found:
            shelf.put(key, _kept[key])
    _kept.move_to_end(key)
    mesh = _kept[key]
    while sum(m.nbytes for m in _kept.values()) > MOST_KEPT:
        _kept.popitem(last=False)
    return mesh


def _made(placed: Placed, scene: Scene, resolution: int) -> Mesh:
    start = time.perf_counter()
    vertices, faces, clipped = _triangles(placed, scene, resolution)
    normals = normals_at(placed, vertices, faces)
    looked_at = worst(vertices, faces, normals, MEASURED)
    errors = of_triangles(placed, vertices, looked_at)
    return _placed_mesh(start, placed, vertices, faces, normals, resolution, looked_at, errors, clipped)


def require_settings(resolution: int = COARSEST, error: float | None = None, share: float = 1.0) -> None:
    """Raises InputError for settings that no mesh can have, whether or not a scene comes to have one."""
    if resolution < COARSEST:
        raise InputError(f"a mesh needs a resolution of at least {COARSEST} cells; found {resolution}")
    if error is not None and not (math.isfinite(error) and error > 0):
        raise InputError(f"the geometric error of a mesh must be a positive number; found {error}")
    if not 0 < share <= 1:
        raise InputError(f"the share of a mesh that keeps its error must lie above 0 and not above 1; found {share}")


def mesh_to_error(obj: Object, scene: Scene, error: float, share: float = 1.0) -> Mesh:
    """`obj` as the coarsest mesh whose triangles stay within `error` of the surface (in the scene's unit of length).

    `share` of the points looked at (error.py), on all triangles, have to keep the error. On a smooth surface it falls with
    the square of the resolution n: a first measurement e predicts n sqrt(e / error). At edges and tips it falls more
    slowly, so that later predictions take the order that the last two measurements show. Raises InputError where
    memory does not suffice, or where the error cannot be measured.
    """
    require_settings(error=error, share=share)
    start, placed, resolution, order = time.perf_counter(), Placed(obj), COARSE, 2.0
    before = None
    for _ in range(MOST_ROUNDS):
        vertices, faces, clipped = _triangles(placed, scene, resolution)
        errors = of_triangles(placed, vertices, faces)
        found = kept(errors, share, 5 * len(faces))
        if math.isinf(found):
            raise InputError(f"the error of a mesh of {obj.name or obj.surface.type} cannot be measured: around "
                             f"{np.isinf(errors).mean():.2%} of its points f shows no change of sign; give a resolution, or "
                             "ask the error of less than the whole surface (share)")
        if before is not None and found < before[1] and resolution > before[0]:
            order = min(2.5, max(0.5, math.log(before[1] / found) / math.log(resolution / before[0])))
        wanted = max(COARSEST, math.ceil(SPARE * resolution * (found / error) ** (1 / order)))
        if (found <= error and wanted >= 0.9 * resolution) or found <= EXACT * error:
            normals = normals_at(placed, vertices, faces)
            return _placed_mesh(start, placed, vertices, faces, normals, resolution, faces, errors, clipped)
        before = resolution, found
        resolution = max(wanted, resolution + 1) if found > error else wanted
    raise InputError(f"a mesh of {obj.name or obj.surface.type} reaches an error of {found:.1g} at {before[0]} cells, "
                     f"not {error:.1g}; choose a larger error or ask it of less than the whole surface (share)")


def _triangles(placed: Placed, scene: Scene, resolution: int) -> tuple[np.ndarray, np.ndarray, str]:
    """Vertices on f = 0 in the surface's own frame, faces, and what was clipped."""
    nothing = np.empty((0, 3)), np.empty((0, 3), np.int64), "no ray can reach it: left out"
    surface, region = placed.surface, placed.region
    if region is not None:
        return *_marched(placed, region, resolution), placed.unproven
    within = reach_in_frame(scene, placed.object)
    if isinstance(surface, Plane):
        patch = plane_patch(surface, within)
        if patch is None:
            return nothing
        return *plane_grid(patch), patch.clipped
    if isinstance(surface, Paraboloid):
        grid = paraboloid_grid(surface, within, resolution)
        if grid is None:
            return nothing
        return *grid[:2], f"cut {grid[2]:.4g} above its apex, beyond all a ray can reach"
    within = tight_box(placed, within)
    if within is None:
        return nothing
    sides = " x ".join(f"{side:.4g}" for side in within[1] - within[0])
    return *_marched(placed, within, resolution), f"cut to a box of {sides} that holds all a ray can reach"


def _marched(placed: Placed, box, resolution: int):
    vertices, faces, cell = march(placed, box, resolution)
    return project(placed, vertices, cell), faces


def _placed_mesh(start: float, placed: Placed, vertices, faces, normals, resolution: int, looked_at, errors,
                 clipped: str) -> Mesh:
    turns = of_normals(placed, vertices, normals, looked_at)
    found = (float(placed.distance(vertices).max(initial=0.0)), float(errors.max()), kept(errors, 0.99, 5 * len(faces)),
             kept(turns, 0.99, 4 * len(faces)))
    return Mesh(placed.to_world(vertices), faces, placed.turned(normals), resolution,
                *(e if math.isfinite(e) else None for e in found), placed.box is not None, clipped,
                time.perf_counter() - start)
