"""Where POV-Ray's rays end, and so how large a scene has to be: a ray of the document ends at max_distance (M5).

POV-Ray forgets whatever a native shape meets farther than 1e7 from a ray's origin, a fixed number of its source. A scene
magnified so that its max_distance is that number therefore ends each ray anew where the document does. POV-Ray's absolute
tolerances (1e-4 for a ray's own surface, 1e-3 for shadows) shrink below 1e-9 of the scene at the same time. Isosurfaces
end at 2e10 only: those that reach farther than max_distance from the camera are clipped, or remarked upon.
"""

from __future__ import annotations

import numpy as np

from raytruth.converters.mesh.placed import Placed
from raytruth.reference_tracer.scene.model import Object, Scene
from raytruth.reference_tracer.scene.placement import corners, reach
from raytruth.reference_tracer.surfaces import Plane

from .cells import holds_everywhere, no_part_of

END = 1e7  # POV-Ray's MAX_DISTANCE


def origins(scene: Scene) -> np.ndarray | None:
    """(2, 3): a box that holds the origin of every ray that looks for a hit; None if they may be anywhere."""
    points = [np.array([scene.camera.position])]
    for obj in scene.objects if scene.tracing.max_depth > 0 else ():
        if obj.material.reflection > 0 or obj.material.transparency > 0:
            placed = Placed(obj)
            if placed.box is None:
                return None
            points.append(placed.corners_in_world())
    return bounds(np.concatenate(points))


def within_distance(scene: Scene, obj: Object) -> bool:
    """Whether no ray's origin is farther than max_distance from any part of `obj`."""
    placed, starts = Placed(obj), origins(scene)
    if placed.box is None or starts is None:
        return False
    return _farthest(starts, bounds(placed.corners_in_world())) <= scene.tracing.max_distance


def far_shadows(scene: Scene) -> str:
    """Which light may be hidden by something farther than max_distance from what it lights; "" if provably none is.

    The document's shadow rays end at their lights, however far; POV-Ray's also where all its rays end.
    """
    region, starts, distance = visited(scene), origins(scene), scene.tracing.max_distance
    for number, light in enumerate(scene.lights, 1):
        lamp = np.array(light.position)
        for lit in scene.objects:
            where = _part_of(region, lit)
            if _all_near(lit, lamp, where, starts, distance):
                continue
            for obj in filter(scene.casts_shadow, scene.objects):
                if not _never_hides_from_afar(obj, lamp, where, distance):
                    return (f"{obj.name or obj.surface.type} may hide light {number} from parts of "
                            f"{lit.name or lit.surface.type} farther than {distance:g} from it")
    return ""


def _part_of(region: np.ndarray, obj: Object) -> np.ndarray:
    """(2, 3): a box that holds what there is of `obj` within `region`."""
    placed = Placed(obj)
    if placed.box is None:
        return region
    low, high = bounds(placed.corners_in_world())
    return np.stack([np.maximum(low, region[0]), np.minimum(high, region[1])])


def _all_near(lit: Object, lamp: np.ndarray, region: np.ndarray, starts: np.ndarray | None, distance: float) -> bool:
    """Whether it is proven that all of `lit` within `region` that rays can reach is within `distance` of `lamp`."""
    if starts is not None and np.all(starts == lamp):  # a light at the camera, and no other rays
        return True

    def near(cells):
        return np.linalg.norm(np.maximum(*np.abs(cells - lamp[:, None])), axis=0) <= distance

    def no_ray_arrives(cells):
        if starts is None:
            return np.zeros(cells.shape[-1], bool)
        gap = np.maximum(np.maximum(starts[0][:, None] - cells[1], cells[0] - starts[1][:, None]), 0)
        return np.linalg.norm(gap, axis=0) > distance

    return holds_everywhere(region, no_part_of(lit), near, no_ray_arrives)


def visited(scene: Scene) -> np.ndarray:
    """(2, 3): a box that holds every point rays can light up. No ray passes an opaque plane that bounds it."""
    low, high = reach(scene)
    for obj in scene.objects:
        if isinstance(obj.surface, Plane) and obj.material.transparency == 0:
            normal = Placed(obj).turned(np.array([obj.surface.a, obj.surface.b, obj.surface.c]))
            axis = int(np.argmax(np.abs(normal)))
            if np.count_nonzero(normal) == 1:
                place = obj.surface.center[axis]
                if scene.camera.position[axis] > place:
                    low[axis] = max(low[axis], place)
                elif scene.camera.position[axis] < place:
                    high[axis] = min(high[axis], place)
    return np.stack([low, high])


def _never_hides_from_afar(obj: Object, lamp: np.ndarray, region: np.ndarray, distance: float) -> bool:
    """Whether it is proven that seen from `lamp` no point of `region` lies more than `distance` behind a part of `obj`."""
    placed, s = Placed(obj), obj.surface
    if isinstance(s, Plane):
        heights = (np.vstack([corners(region), lamp]) - np.array(s.center)) @ placed.turned(np.array([s.a, s.b, s.c]))
        return bool(np.all(heights >= 0) or np.all(heights <= 0))
    if placed.box is None:
        return False

    def none_behind(cells):
        low, high = (ends - lamp[:, None] for ends in cells)
        # a point behind q is lamp + (q - lamp) * s with s > 1 + distance / |q - lamp|
        stretch = 1 + distance / np.linalg.norm(np.maximum(np.abs(low), np.abs(high)), axis=0)
        place = lamp[:, None]
        return np.any((low > 0) & (place + low * stretch > region[1][:, None])
                      | (high < 0) & (place + high * stretch < region[0][:, None]), axis=0)

    return holds_everywhere(bounds(placed.corners_in_world()), no_part_of(obj), none_behind)


def bounds(points: np.ndarray) -> np.ndarray:
    """(2, 3): the box of `points` (n, 3)."""
    return np.stack([points.min(axis=0), points.max(axis=0)])


def _farthest(a: np.ndarray, b: np.ndarray) -> float:
    """The largest distance between points of the boxes a and b."""
    return float(np.linalg.norm(np.maximum(np.abs(a[1] - b[0]), np.abs(b[1] - a[0]))))
