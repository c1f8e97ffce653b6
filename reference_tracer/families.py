"""Tables of objects that share one f, for one loop each inside a kernel.

Objects that share f are rows of one table and are visited by one loop. A kernel therefore depends on which families,
lights and materials a scene uses, not on how many objects there are or where they stand: one hundred spheres compile
like one, and the figures of the document share their kernels.
"""

from __future__ import annotations

from dataclasses import dataclass

import drjit as dr
import numpy as np

from .backend import Backend
from .first_hit import LocalRay, Solid
from .numbers import Dual
from .placement import rotation_matrix
from .scene.model import Object

BOX_MARGIN = 1e-6  # relative; keeps crossings on the box's own faces, where a sphere touches it, inside


@dataclass
class Member:
    """One object of a family in every lane: its place, its parameters and its solid."""

    index: object  # UInt, the object in scene order
    center: object  # Vector
    rotation: list | None  # three columns (Vector) of the rotation matrix, or None for the identity
    solid: Solid

    def local(self, o, d) -> LocalRay:
        return LocalRay(self._into(o - self.center), self._into(d))

    def _into(self, v):
        return v if self.rotation is None else type(v)(*(dr.dot(column, v) for column in self.rotation))

    def normal_at(self, point):
        """The gradient of the regular form at `point`, in world space, not normalised (decision N1)."""
        g = self.solid.regular(*Dual.axes(self._into(point - self.center)))
        gradient = type(point)(*(g.derivative(k) for k in range(3)))
        if self.rotation is None:
            return gradient
        x, y, z = self.rotation
        return x * gradient[0] + y * gradient[1] + z * gradient[2]


class Family:
    """The objects of a scene that share one f, as a table; row j holds the numbers of the j-th of them."""

    def __init__(self, arrays: Backend, indices: list[int], objects: list[Object], method):
        surface = objects[0].surface
        self.arrays, self.method = arrays, method
        self.indices = indices
        self.forms = surface.function, surface.regular_form, surface.polynomial_form
        self.parameters = tuple(surface.parameters)
        self.rotated = any(o.rotation is not None for o in objects)
        self.bounded = all(o.surface.box() is not None for o in objects)
        self.flipped = any(o.surface.inside == "positive" for o in objects)

        rows = [self._row(o) for o in objects]
        self.width = len(rows[0])
        self.table = arrays.Float(np.array(rows, dtype=float).ravel().tolist())
        self.index_of_row = arrays.UInt(indices)
        self.count = arrays.count(len(objects))
        dr.make_opaque(self.table, self.index_of_row)

    def _row(self, obj: Object) -> list[float]:
        surface = obj.surface
        row = [*surface.center, *surface.parameters.values()]
        if self.rotated:
            row += rotation_matrix(obj.rotation).T.ravel().tolist()
        if self.bounded:
            low, high = (np.array(corner) for corner in surface.box())
            margin = BOX_MARGIN * (high - low)
            row += [*(low - margin), *(high + margin)]
        if self.flipped:
            row += [-1.0 if surface.inside == "positive" else 1.0]
        return row

    def member(self, j, active=True) -> Member:
        """Row `j` (UInt array) of the table."""
        arrays = self.arrays
        cursor = iter(range(self.width))
        number = lambda: dr.gather(arrays.Float, self.table, j * self.width + next(cursor), active)
        vector = lambda: arrays.Vector(number(), number(), number())

        center = vector()
        parameters = {name: number() for name in self.parameters}
        rotation = [vector(), vector(), vector()] if self.rotated else None
        box = (vector(), vector()) if self.bounded else None
        sign = number() if self.flipped else None

        def signed(form):
            if form is None or sign is None:
                return form and (lambda x, y, z: form(x, y, z, **parameters))
            return lambda x, y, z: form(x, y, z, **parameters) * sign

        far_inside = arrays.Bool(False) if sign is None else sign < 0
        solid = Solid(*map(signed, self.forms), box, far_inside)
        return Member(dr.gather(arrays.UInt, self.index_of_row, j, active), center, rotation, solid)
