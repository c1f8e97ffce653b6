from __future__ import annotations

from typing import ClassVar, Literal

from pydantic import model_validator

from .surface import Finite, Surface


class Plane(Surface):
    """A half-space behind a plane with normal (a, b, c) through `center` (section 7.1.1). Unbounded."""

    type: Literal["plane"] = "plane"
    a: Finite
    b: Finite
    c: Finite

    title: ClassVar[str] = "Plane"
    equation: ClassVar[str] = "a(x − x₀) + b(y − y₀) + c(z − z₀) = 0"
    polynomial_degree: ClassVar[int] = 1

    @model_validator(mode="after")
    def _has_a_normal(self):
        if max(abs(self.a), abs(self.b), abs(self.c)) < 1e-6:
            raise ValueError("the normal (a, b, c) must not be zero: give the direction the plane faces, "
                             'for instance "a": 0, "b": 1, "c": 0')
        return self

    @staticmethod
    def f(x, y, z, a, b, c):
        return x * a + y * b + z * c
