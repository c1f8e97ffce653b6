"""Objects as POV-Ray shapes at their place: native ones where POV-Ray has the exact one, isosurfaces else."""

from __future__ import annotations

import numpy as np

from raytruth.converters.mesh.placed import Placed
from raytruth.reference_tracer.scene.model import Object
from raytruth.reference_tracer.scene.placement import rotation_matrix
from raytruth.reference_tracer.surfaces import Ellipsoid, Paraboloid, Plane, Sphere, Torus

from .text import function_text
from .words import number, vector

MARGIN = 1e-6  # of its size: a container's faces stay clear of a surface that touches its box


def native(obj: Object, scale: float) -> str | None:
    """The exact POV-Ray shape of `obj`, `scale` times as large, its braces still open; None where there is none."""
    center = scale * np.array(obj.surface.center)
    turn = rotation_matrix(obj.rotation)
    match obj.surface:
        case Plane() as s:
            normal = turn @ (np.array([s.a, s.b, s.c]) / np.linalg.norm([s.a, s.b, s.c]))
            return f"plane {{ {vector(normal)}, {number(normal @ center)}"
        case Sphere() as s:
            return f"sphere {{ {vector(center)}, {number(scale * s.r)}"
        case Ellipsoid() as s:
            return f"sphere {{ 0, 1 {_matrix(scale * turn * np.array([s.a, s.b, s.c]), center)}"
        case Paraboloid() as s:
            return (f"quadric {{ {vector([1 / s.a**2, 1 / s.b**2, 0])}, <0,0,0>, <0,0,-1>, 0 "
                    f"{_matrix(scale * turn, center)}")
        case Torus() as s if s.r < s.R:  # a tube that overlaps itself has an inner sheet there (decision O4)
            about_y = np.array([[1, 0, 0], [0, 0, -1], [0, 1, 0]])  # POV-Ray's axis is y, the document's z
            return f"torus {{ {number(s.R)}, {number(s.r)} sturm {_matrix(scale * turn @ about_y, center)}"
    return None


def isosurface(obj: Object, scale: float, container: np.ndarray, accuracy: float, max_gradient: float,
               every_root: bool) -> str:
    """`obj` as an isosurface of its regular form within `container` (2, 3), in the surface's own frame.

    Finding only the first root of a ray takes half the time. What is clipped needs `every_root`, and so do rays that
    start on the surface, whose first root may be their own origin.
    """
    center = scale * np.array(obj.surface.center)
    low, high = container
    roots = "all_intersections" if every_root else "max_trace 1"
    return (f"isosurface {{ function {{ {function_text(obj.surface)} }} "
            f"contained_by {{ box {{ {vector(low)}, {vector(high)} }} }} accuracy {number(accuracy)} "
            f"max_gradient {number(max_gradient)} {roots} open "
            f"{_matrix(scale * rotation_matrix(obj.rotation), center)}")


def own_container(placed: Placed) -> np.ndarray | None:
    """(2, 3): the region of a surface that has one, with room to spare."""
    if placed.region is None:
        return None
    low, high = placed.region
    margin = MARGIN * (high - low)
    return np.stack([low - margin, high + margin])


def _matrix(linear: np.ndarray, shift: np.ndarray) -> str:
    """POV-Ray multiplies rows: the images of the axes, then the shift."""
    return f"matrix {vector([*linear.T.ravel(), *shift])}"
