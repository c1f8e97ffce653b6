"""The scenes that come with raytruth: every picture of the document."""

from __future__ import annotations

from functools import cache
from importlib.resources import files

from ..errors import InputError
from .load import load_scene, parse_scene
from .model import Scene

_DOCUMENTS = files(__package__) / "documents"


@cache
def names() -> tuple[str, ...]:
    """The names of the shipped scenes, in the order of the document's figures."""
    return tuple(sorted(f.name.removesuffix(".json") for f in _DOCUMENTS.iterdir() if f.name.endswith(".json")))


@cache
def scene(name: str) -> Scene:
    """The shipped scene called `name`. Raises InputError if there is none."""
    if name not in names():
        raise InputError(f"{name}: is neither a file nor a shipped scene; 'raytruth scenes' lists those")
    document = _DOCUMENTS / f"{name}.json"
    return parse_scene(document.read_bytes(), document.name)


def find(name_or_path: str) -> Scene:
    """A shipped scene by its name, or a scene file by its path. Raises InputError."""
    return scene(name_or_path) if name_or_path in names() else (
        load_scene(name_or_path) if "/" in name_or_path or name_or_path.endswith(".json") else scene(name_or_path))
