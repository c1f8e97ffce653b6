"""Any scene as triangle meshes in Embree, one acceleration structure an object, reached through trimesh and embreex."""

from .crossings import Crossings, Hit
from .scene import EmbreeScene, Solid, convert

__all__ = ["Crossings", "EmbreeScene", "Hit", "Solid", "convert"]
