"""Where an object stands, from its own frame into the world and back, and which part of space rays can visit."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:  # a scene is checked with what stands here
    from .model import Object, Rotation, Scene


def rotation_matrix(rotation: Rotation | None) -> np.ndarray:
    """The (3, 3) matrix that turns the surface's own frame into the world (Rodrigues' formula)."""
    if rotation is None:
        return np.eye(3)
    k = np.array(rotation.axis) / np.linalg.norm(rotation.axis)
    turns = rotation.degrees / 90.0
    if turns == int(turns):  # quarter turns exactly: cos(90 degrees) must be 0, not 6e-17
        cos, sin = ((1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0))[int(turns) % 4]
    else:
        cos, sin = math.cos(math.radians(rotation.degrees)), math.sin(math.radians(rotation.degrees))
    cross = np.array([[0, -k[2], k[1]], [k[2], 0, -k[0]], [-k[1], k[0], 0]])
    return cos * np.eye(3) + sin * cross + (1 - cos) * np.outer(k, k)


def is_inside(obj: Object, point, literal: bool = False) -> bool:
    """Whether `point` (world space) lies inside the object: f < 0 (decision O1). The side of a camera ray (M3).

    From the regular form, whose sign does not drown where f leaves the range of doubles; `literal`: from f as written.
    """
    local = rotation_matrix(obj.rotation).T @ (np.asarray(point, float) - np.array(obj.surface.center))
    form = obj.surface if literal else obj.surface.regular
    with np.errstate(all="ignore"):  # arrays: Python's own floats raise where IEEE arithmetic divides by zero
        value = np.ravel(form(*local[:, np.newaxis]))[0]
    return bool(-np.inf < value < 0)


def corners(box) -> np.ndarray:
    """(8, 3): the corners of the box [low, high]."""
    return np.array([[box[i][0], box[j][1], box[k][2]] for i in (0, 1) for j in (0, 1) for k in (0, 1)])


def corners_in_world(obj: Object, box) -> np.ndarray:
    """(8, 3): the corners, in world space, of a `box` in the object's own frame."""
    return corners(box) @ rotation_matrix(obj.rotation).T + np.array(obj.surface.center)


def reach(scene: Scene) -> np.ndarray:
    """(2, 3): low and high corner of a box in world space that no ray of `scene` leaves: what lies outside never shows.

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
