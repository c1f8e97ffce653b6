"""Which part of space the rays of a scene can visit: what lies outside of it never shows and need not be meshed."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from .placement import corners, corners_in_world, rotation_matrix

if TYPE_CHECKING:  # a scene is checked with what stands here
    from .scene.model import Object, Scene


def reach(scene: Scene) -> np.ndarray:
    """(2, 3): low and high corner of a box in world space that no ray of `scene` leaves.

    Every ray ends max_distance from its origin (decision M5). Origins are the camera and points on objects that reflect
    or transmit. If those are bounded, they lie in their boxes whatever the number of generations; an unbounded one can
    be met anywhere, so that each of the max_depth generations may carry a ray max_distance further. Shadow rays end at
    lights: a box is convex, so it holds them if it holds both ends.
    """
    tracing = scene.tracing
    shiny = [(o, o.surface.box()) for o in scene.objects if o.material.reflection > 0 or o.material.transparency > 0]
    origins = [np.array([scene.camera.position])]
    origins += [corners_in_world(o, box) for o, box in shiny if box is not None]
    endless = tracing.max_depth > 0 and any(box is None for _, box in shiny)
    distance = tracing.max_distance * (1 + (tracing.max_depth if endless else 0))
    points = np.concatenate(origins)
    low, high = points.min(axis=0) - distance, points.max(axis=0) + distance
    lights = np.array([light.position for light in scene.lights]).reshape(-1, 3)
    return np.stack([np.minimum(low, lights.min(axis=0, initial=np.inf)),
                     np.maximum(high, lights.max(axis=0, initial=-np.inf))])


def reach_in_frame(scene: Scene, obj: Object) -> np.ndarray:
    """(2, 3): a box in the own frame of `obj` that holds `reach(scene)`."""
    points = (corners(reach(scene)) - np.array(obj.surface.center)) @ rotation_matrix(obj.rotation)
    return np.stack([points.min(axis=0), points.max(axis=0)])
