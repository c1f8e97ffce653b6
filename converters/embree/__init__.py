"""Any scene as triangle meshes in Embree, one acceleration structure an object, reached through trimesh and embreex."""

from .crossings import EmbreeIntersector
from .scene import EmbreeScene, Solid, convert

__all__ = ["EmbreeIntersector", "EmbreeScene", "Solid", "convert"]
