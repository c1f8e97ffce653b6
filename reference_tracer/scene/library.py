"""The scenes that come with raytruth: every picture of the document, and one scene for each effect of its model."""

from __future__ import annotations

import difflib
from functools import cache
from importlib.resources import files

from ..errors import InputError
from .load import load_scene, parse_scene, printable
from .model import Scene

_DOCUMENTS, _EFFECTS = files(__package__) / "documents", files(__package__) / "effects"

PUBLISHED = "@published"  # behind a scene's name: its figure's form


@cache
def names() -> tuple[str, ...]:
    """The names of the scenes of the document, in the order of its figures."""
    return _in(_DOCUMENTS)


@cache
def effects() -> tuple[str, ...]:
    """The names of the scenes that show one effect each, in the order of sections 4.3.1 to 5."""
    order = ("shading", "shadow", "reflection", "refraction", "total-reflection", "mixing", "multisampling")
    return tuple(sorted(_in(_EFFECTS), key=lambda name: order.index(name.removeprefix("effect-"))))


def _in(folder) -> tuple[str, ...]:
    return tuple(sorted(f.name.removesuffix(".json") for f in folder.iterdir() if f.name.endswith(".json")))


@cache
def scene(name: str) -> Scene:
    """The shipped scene called `name`. Raises InputError if there is none."""
    if name not in (*names(), *effects()):
        meant = _nearest(name)
        raise InputError(f"{printable(name)}: is neither a file nor a shipped scene; "
                         + (f"did you mean {meant}? " if meant else "") + "'raytruth scenes' lists those")
    document = (_DOCUMENTS if name in names() else _EFFECTS) / f"{name}.json"
    return parse_scene(document.read_bytes(), document.name)


def _nearest(written: str) -> str | None:
    """The shipped scene that somebody may mean by `written`: one that has it as a part, or is spelt nearly so."""
    known, written = (*names(), *effects()), written[:60].lower()
    parts = [name for name in known if written and written in name]
    return parts[0] if len(parts) == 1 else next(iter(difflib.get_close_matches(written, parts or known, 1, 0.7)), None)


def find(name_or_path: str) -> Scene:
    """A shipped scene by its name, or a scene file by its path; with @published behind it, as the document's figure shows
    it (`Scene.figure_form`). Raises InputError."""
    name, _, form = name_or_path.rpartition("@") if name_or_path.endswith(PUBLISHED) else (name_or_path, "", "")
    found = load_scene(name) if "/" in name or name.endswith(".json") else scene(name)
    return found.figure_form() if form else found
