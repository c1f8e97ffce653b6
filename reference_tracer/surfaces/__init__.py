"""The surfaces of section 7.1 and the user's own: one file, one surface, one function f(x, y, z).

To add a surface: write a file like sphere.py and list its class in KINDS. Scene files, methods, meshes and exports
then know it.
"""

from typing import Annotated, Union

from pydantic import AfterValidator, Field, WrapSerializer

from .clipped import Clipped
from .csg import Csg
from .ellipsoid import Ellipsoid
from .expression import Expression
from .heart import Heart
from .paraboloid import Paraboloid
from .plane import Plane
from .sphere import Sphere
from .surface import Bounds, Box, Surface
from .torus import Torus

KINDS: tuple[type[Surface], ...] = (Plane, Sphere, Ellipsoid, Torus, Paraboloid, Heart, Expression, Csg)

# as scene files have them
AnySurface = Annotated[Union[KINDS], Field(discriminator="type"), AfterValidator(Clipped.made),  # noqa: UP007
                       WrapSerializer(Clipped.document)]
Csg.model_rebuild(_types_namespace={"AnySurface": AnySurface})

__all__ = ["KINDS", "AnySurface", "Bounds", "Box", "Clipped", "Csg", "Ellipsoid", "Expression", "Heart", "Paraboloid", "Plane",
           "Sphere", "Surface", "Torus"]
