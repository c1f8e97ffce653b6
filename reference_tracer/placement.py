"""Where an object stands: from its own frame into the world and back."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:  # a scene is checked with what stands here
    from .scene.model import Object, Rotation


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
