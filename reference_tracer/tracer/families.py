"""Tables of objects that share one f.

Objects that share f are rows of one table. A family of few objects is unrolled: each row's numbers are scalars of the
kernel, which cost nothing to read. A larger one is visited by a loop, so that one hundred spheres compile like one. A
kernel therefore depends on which families, lights and materials a scene uses, not on where anything stands.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import drjit as dr
import numpy as np

from ..backend import Backend
from ..first_hit import LocalRay, Solid
from ..numbers import Dual, OutwardInterval
from ..scene.model import Object
from ..scene.placement import rotation_matrix
from ..surfaces.outside import widened
from .bounds import SIZE, Ball, bounding_ball, cluster_balls, spatial_order

ROUNDING_OF_TURNS = 2.0**-49  # of a rotation matrix's entries, at most: sine, cosine and axis, a dozen operations
MOST_UNROLLED = 16  # objects of one family; beyond it the kernel's length costs more than reading a table


@dataclass
class Member:
    """One object of a family in every lane: its place, its parameters and its solid."""

    index: object  # UInt, the object in scene order
    center: object  # Vector
    rotation: list | None  # three columns (Vector) of the rotation matrix, or None for the identity
    solid: Solid
    ball: Ball | None  # that holds the solid's surface; None where it is unbounded
    enclosed: Callable  # the regular form on intervals, its parameters intervals too

    def local(self, o, d) -> LocalRay:
        return LocalRay(self._into(o - self.center), self._into(d))

    def _into(self, v):
        return v if self.rotation is None else type(v)(*(dr.dot(column, v) for column in self.rotation))

    def signs_at(self, o, d, t):
        """Whether f at o + t d is negative, and whether it is positive, for certain (Bools).

        Every rounding counts, those on the way into the object's own frame too: signs of different objects compare.
        """
        t = OutwardInterval(t)
        p = [t * d[k] + o[k] - self.center[k] for k in range(3)]
        if self.rotation is not None:
            entry = lambda c: OutwardInterval(c - ROUNDING_OF_TURNS, c + ROUNDING_OF_TURNS)
            p = [p[0] * entry(column[0]) + p[1] * entry(column[1]) + p[2] * entry(column[2]) for column in self.rotation]
        g = OutwardInterval.of(self.enclosed(*p))
        return g.high < 0, g.low > 0

    def normal_at(self, point):
        """The gradient of the regular form at `point`, in world space, not normalised (decision N1)."""
        g = self.solid.regular(*Dual.axes(self._into(point - self.center)))
        gradient = type(point)(*(g.derivative(k) for k in range(3)))
        if self.rotation is None:
            return gradient
        x, y, z = self.rotation
        return x * gradient[0] + y * gradient[1] + z * gradient[2]


class Family:
    """The objects of a scene that share one f and its sign outside of their boxes, as a table; row j holds the numbers of
    the j-th of them."""

    def __init__(self, arrays: Backend, indices: list[int], objects: list[Object], method, casts_shadow: bool):
        surface = objects[0].surface
        self.arrays, self.method = arrays, method
        self.sign_outside = surface.sign_outside
        self.bounded = self.sign_outside != 0
        self.clustered = self.bounded and len(objects) > MOST_UNROLLED
        if self.clustered:
            order = spatial_order(np.array([o.surface.center for o in objects]))
            indices, objects = [indices[k] for k in order], [objects[k] for k in order]
        self.indices = indices
        self.forms = surface.function, surface.regular_form, surface.polynomial_form
        self.programs = getattr(surface, "variables", ())  # what an interpreter reads
        shared = [surface.literal_parameters and len({repr(o.surface.parameters[name]) for o in objects}) == 1
                  for name in surface.parameters]
        self.parameters = [name for name, same in zip(surface.parameters, shared) if not same]
        self.rotated = any(o.rotation is not None for o in objects)
        self.casts_shadow = casts_shadow
        self.flipped = any(o.surface.inside == "positive" for o in objects)

        # a ball that a ray misses spares what costs more than to ask: a search, or the reading of a row
        self.asks_bounds = self.bounded and not (method.closed_form and not self.clustered)
        self.rows = [self._row(o) for o in objects]
        self.width = len(self.rows[0])
        self.table = arrays.Float(np.array(self.rows, dtype=float).ravel().tolist())
        self.index_of_row = arrays.UInt(indices)
        self.count = arrays.count(len(objects))
        dr.make_opaque(self.table, self.index_of_row)

    def _row(self, obj: Object) -> list[float]:
        surface = obj.surface
        row = [*surface.center, *(surface.parameters[name] for name in self.parameters)]
        if self.rotated:
            row += rotation_matrix(obj.rotation).T.ravel().tolist()
        if self.bounded:
            low, high = widened(surface.box())
            row += [*low, *high, bounding_ball(np.array(low), np.array(high))]
        if self.flipped:
            row += [-1.0 if surface.inside == "positive" else 1.0]
        return row

    def member(self, j, active=True) -> Member:
        """Row `j` (UInt array) of the table."""
        arrays = self.arrays
        columns = iter(range(self.width))
        return self._member(lambda: dr.gather(arrays.Float, self.table, j * self.width + next(columns), active),
                            dr.gather(arrays.UInt, self.index_of_row, j, active))

    @cached_property
    def _members(self) -> list[Member]:
        """Every row, its numbers as scalars that kernels read at run time."""
        members = []
        for (index, *numbers) in self._scalars:
            rest = iter(numbers)
            members.append(self._member(lambda: next(rest), index))
        return members

    @cached_property
    def _scalars(self) -> list[list]:
        """For every row the index of its object and its numbers."""
        if len(self.rows) > MOST_UNROLLED:
            return []
        return [[self.arrays.count(index), *map(self.arrays.constant, row)]
                for index, row in zip(self.indices, self.rows)]

    @property
    def variables(self) -> list:
        """All arrays that kernels read of the family."""
        return [self.table, self.index_of_row, self.count, self._scalars, self._clusters, self.method.variables, self.programs]

    def _member(self, number: Callable, index) -> Member:
        """The member whose numbers, in the order of `_row`, are what `number` returns one by one."""
        arrays = self.arrays
        vector = lambda: arrays.Vector(number(), number(), number())
        center = vector()
        parameters = {name: number() for name in self.parameters}
        rotation = [vector(), vector(), vector()] if self.rotated else None
        box = (vector(), vector()) if self.bounded else None
        radius = number() if self.bounded else None
        sign = number() if self.flipped else None

        def signed(form):
            if form is None or sign is None:
                return form and (lambda x, y, z: form(x, y, z, **parameters))
            return lambda x, y, z: form(x, y, z, **parameters) * sign

        _, regular, _ = self.forms
        intervals = {name: OutwardInterval(value) for name, value in parameters.items()}
        enclosed = lambda x, y, z: regular(x, y, z, **intervals) if sign is None else regular(x, y, z, **intervals) * sign
        if sign is None:
            far_inside = arrays.Bool(self.sign_outside < 0)
        else:
            far_inside = sign > 0 if self.sign_outside < 0 else sign < 0
        forms = {form: signed(form) for form in self.forms}  # one and the same where they are
        solid = Solid(*(forms[form] for form in self.forms), box, far_inside)
        return Member(index, center, rotation, solid, Ball(center, radius) if self.bounded else None, enclosed)

    @cached_property
    def _clusters(self):
        """The balls around SIZE rows each, as a table (Float) of four columns."""
        rows = np.array(self.rows) if self.clustered else np.zeros((0, self.width))
        radius = self.width - (2 if self.flipped else 1)  # see _row
        table = self.arrays.Float(cluster_balls(rows[:, :3], rows[:, radius]).ravel().tolist() or [0.0])
        dr.make_opaque(table)
        return table

    def fold(self, step: Callable[..., tuple], state: tuple, worth: Callable[..., object],
             unrolled: bool = True) -> tuple:
        """`state = step(member, *state)` for every member in turn; what is returned is the last state.

        Members are left out of lanes where `worth(ball, *state)` is false for a ball that holds them. What is seldom
        asked for is better not `unrolled`: kernels stay short.
        """
        asked = lambda member, *state: step(member, *state) if not self.asks_bounds else dr.if_stmt(
            state, worth(member.ball, *state), lambda *state: step(member, *state), lambda *state: state)
        if unrolled and len(self.rows) <= MOST_UNROLLED:
            for member in self._members:
                state = asked(member, *state)
            return state
        from_row = lambda start, stop, state: dr.while_loop(
            (self.arrays.UInt(start), *state), lambda j, *state: j < stop,
            lambda j, *state: (j + 1, *asked(self.member(j), *state)))[1:]
        if not self.clustered:
            return from_row(0, self.count, state)

        def cluster(start, *state):
            number = lambda k: dr.gather(self.arrays.Float, self._clusters, start // SIZE * 4 + k)
            ball = Ball(self.arrays.Vector(number(0), number(1), number(2)), number(3))
            stop = dr.minimum(start + SIZE, self.count)
            return start + SIZE, *dr.if_stmt(state, worth(ball, *state), lambda *state: from_row(start, stop, state),
                                             lambda *state: state)

        return dr.while_loop((self.arrays.UInt(0), *state), lambda start, *state: start < self.count, cluster)[1:]
