"""Any surface as a triangle mesh whose vertices lie on f = 0 in fp64, with the error of what lies between them."""

from .check import Check, check
from .convert import mesh_object, mesh_to_error, require_settings
from .error import largest
from .mesh import Mesh

__all__ = ["Check", "Mesh", "check", "largest", "mesh_object", "mesh_to_error", "require_settings"]
