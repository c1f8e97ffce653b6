"""What every surface is: one function f(x, y, z), and the few facts that cannot be derived from it."""

from __future__ import annotations

from collections.abc import Callable
from typing import Annotated, ClassVar, Literal

from pydantic import BaseModel, ConfigDict, Field, model_validator

LARGEST_COORDINATE = 1e6  # beyond it fp64 has no digits left for surface detail of size 1e-9

Finite = Annotated[float, Field(allow_inf_nan=False, ge=-LARGEST_COORDINATE, le=LARGEST_COORDINATE)]
Length = Annotated[float, Field(allow_inf_nan=False, gt=1e-6, le=LARGEST_COORDINATE)]
Vector = tuple[Finite, Finite, Finite]
Box = tuple[tuple[float, float, float], tuple[float, float, float]]


class Bounds(BaseModel):
    """Two opposite corners of a box, in the surface's own frame."""

    model_config = ConfigDict(frozen=True, extra="forbid", strict=True, allow_inf_nan=False)
    low: Vector
    high: Vector

    @model_validator(mode="after")
    def _in_order(self):
        if any(low >= high for low, high in zip(self.low, self.high)):
            raise ValueError("every number of low must be smaller than the one of high")
        return self

    @property
    def corners(self) -> Box:
        return self.low, self.high


class Surface(BaseModel):
    """The zero set of f(x, y, z) and the solid f < 0 inside it.

    f is written in the surface's own frame, whose origin is `center`: the printed equations of section 7.1 with
    x - x0 written as x. A subclass gives f as a static method of the coordinates and of its parameters, coordinates
    on the left of parameters in every operation (an interval may stand only on the left of a Dr.Jit array).
    """

    model_config = ConfigDict(frozen=True, extra="forbid", strict=True, allow_inf_nan=False)

    type: str
    center: Vector = Field(default=(0.0, 0.0, 0.0), description="(x0, y0, z0), the origin of the surface's own frame")
    inside: Literal["negative", "positive"] = Field(
        default="negative", description="the sign of f inside the solid; zero is always outside")
    clip: Bounds | None = Field(default=None, description="only what lies within this box, in the surface's own frame, belongs "
                                        "to the solid; its faces close it")

    title: ClassVar[str]
    equation: ClassVar[str]
    literal_parameters: ClassVar[bool] = False  # whether those that a whole family shares are literals of its kernels
    polynomial_degree: ClassVar[int | None] = None  # of polynomial_form, where there is one

    @staticmethod
    def f(x, y, z, **parameters):
        raise NotImplementedError

    @property
    def function(self) -> Callable:
        """f(x, y, z, **parameters) on any number type."""
        return type(self).f

    @property
    def regular_form(self) -> Callable:
        """A function with the zeros and the signs of f whose gradient does not vanish where grad f does.

        It is f itself for every regular surface. Normals and safeguarded roots are computed from it.
        """
        return self.function

    @property
    def parameters(self) -> dict[str, float]:
        """The numbers f takes beside the coordinates, under the symbols of section 7.1."""
        own = set(type(self).model_fields) - set(Surface.model_fields)
        return {name: getattr(self, name) for name in type(self).model_fields if name in own}

    @property
    def family(self) -> str:
        """Surfaces of one family share f and differ in parameters only: a kernel evaluates a family in one loop."""
        return self.type

    @property
    def degree(self) -> int | None:
        """The degree of `polynomial_form`, None where there is none."""
        return self.polynomial_degree

    @property
    def polynomial_form(self) -> Callable | None:
        """A polynomial of the coordinates with the zeros and the signs of f; None where the surface has none.

        It is f itself wherever f is a polynomial.
        """
        return self.function if self.degree is not None else None

    @property
    def exact_form(self) -> Callable | None:
        """The polynomial that exact arithmetic decides by: f as written where that is one, else `polynomial_form`."""
        return self.polynomial_form

    @property
    def bounded_quadric(self) -> bool:
        """Whether a `polynomial_form` of degree two is one of an ellipsoid, which every line cuts twice or not at all."""
        return self.box() is not None

    @property
    def drowns(self) -> bool:
        """Whether rounding in f may move the surface further than methods that do not count it allow for (conditioning.py)."""
        return False

    def box(self) -> Box | None:
        """Corners (low, high), in the surface's own frame, of a box outside which f provably has one sign, else None."""
        return None

    @property
    def sign_outside(self) -> int:
        """The sign of `function` outside of `box`, +1 or -1; 0 where there is no box."""
        return 1 if self.box() is not None else 0

    def region(self) -> Box | None:
        """Where a mesh looks for the surface: its `box`, or the one that its user promises and nothing proves."""
        return self.box()

    def __call__(self, x, y, z):
        """f at points of the surface's own frame, the sign flipped where `inside` says so."""
        value = self.function(x, y, z, **self.parameters)
        return -value if self.inside == "positive" else value

    def regular(self, x, y, z):
        """The regular form at points of the surface's own frame, signed as `__call__`."""
        value = self.regular_form(x, y, z, **self.parameters)
        return -value if self.inside == "positive" else value
