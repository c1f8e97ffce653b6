"""Scenes as files of other programs: the ending of the file's name says of which.

    .ply .obj .stl .glb   meshes of one object or of all, with how far they are from the surfaces
    .xml                  Mitsuba 3: `mitsuba FILE`, with a PLY file beside it for every object that is a mesh
    .pov                  POV-Ray 3.7
    .txt                  plain text for ports of the document (plain.py)
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING, TypeVar

from raytruth.reference_tracer.errors import InputError
from raytruth.reference_tracer.scene.load import printable
from raytruth.reference_tracer.scene.model import Scene
from raytruth.reference_tracer.writing import atomically, require_file

from .mesh import Mesh, mesh_object
from .mesh.files import SUFFIXES, as_trimesh, bound, encoded, rounded_up
from .mesh.marching import MOST_TRIANGLES

if TYPE_CHECKING:
    import trimesh

Key = TypeVar("Key")
T = TypeVar("T")
ENDINGS = (*SUFFIXES, ".xml", ".pov", ".txt")
CELLS = 256  # along the longest side of a mesh


@dataclass(frozen=True)
class Exported:
    """What was written."""

    files: tuple[Path, ...]  # the one asked for comes first
    told: tuple[str, ...]  # lines: the errors of meshes, what was cut off or left out, what the format cannot express


def export(scene: Scene, path: str | Path, object: str | int | None = None, cells: int = CELLS) -> Exported:
    """Writes `scene` to `path` in the format that its ending names, whole or not at all.

    `object`, a name or a number in scene order, asks a mesh file for one object. Meshes have `cells` cells along their
    longest side. Raises InputError for a file, an object or a mesh that cannot be, UnsupportedError where the format
    cannot express the scene.
    """
    path, suffix = Path(path), Path(path).suffix.lower()
    if suffix not in ENDINGS:
        raise InputError(f"{path}: the output must end in one of {', '.join(ENDINGS)}")
    require_file(path)
    if suffix in SUFFIXES:
        contents, told = _meshes(scene, path, suffix, chosen(scene, object), cells)
    elif object is not None:
        raise InputError(f"{path}: holds a whole scene; one object goes to {', '.join(SUFFIXES)}")
    elif suffix == ".xml":
        contents, told = _mitsuba(scene, path, cells)
    elif suffix == ".pov":
        contents, told = _povray(scene, path)
    else:
        from .plain import plain

        contents, told = {path: plain(scene).encode("ascii")}, []
    for file in contents:
        require_file(file)
    for file, content in reversed(contents.items()):  # the one that names the others comes last
        with atomically(file) as part:
            part.write_bytes(content)
    return Exported(tuple(contents), tuple(told))


def mesh(scene: Scene, object: str | int, cells: int = CELLS) -> trimesh.Trimesh:
    """One object of `scene`, by its name or number in scene order, as a mesh of `cells` cells along its longest side.

    Vertices are fp64 and lie on f = 0, vertex normals are grad f; `metadata` says how far triangles are from the surface
    ("error_bound", in the scene's unit; None: not measurable) and what was cut off ("clipped"). Raises InputError.
    """
    k, = chosen(scene, object)
    return as_trimesh(_required(scene, _meshed(scene, [k], cells))[k], object=k, name=scene.objects[k].name)


def chosen(scene: Scene, wanted: str | int | None) -> list[int]:
    """The objects that `wanted`, a name or a number in scene order, stands for; None for all. Raises InputError."""
    if wanted is None:
        return list(range(len(scene.objects)))
    called = [k for k, obj in enumerate(scene.objects) if obj.name and obj.name == wanted]
    if len(called) > 1:
        raise InputError(f"{len(called)} objects are called {printable(str(wanted))!r}; give the number of one: "
                         f"{', '.join(map(str, called[:9]))}")
    if called:
        return called
    number = str(wanted)
    if number.isascii() and number.isdigit() and len(number) < 9 and int(number) < len(scene.objects):
        return [int(number)]
    names = ", ".join(repr(printable(obj.name)) for obj in scene.objects[:9] if obj.name)
    raise InputError(f"{scene.name}: has no object {printable(number)!r}; give a number from 0 to {len(scene.objects) - 1}"
                     + (f", or a name: {names}" if names else ""))


def _meshed(scene: Scene, objects: list[int], cells: int) -> dict[int, Mesh]:
    """The meshes of `objects` that a ray can reach. Raises InputError where all together have too many triangles."""
    made, triangles = {}, 0
    for k in objects:
        found = mesh_object(scene.objects[k], scene, cells)
        triangles += found.triangles
        if triangles > MOST_TRIANGLES:
            raise InputError(f"{scene.name}: the meshes of {cells} cells have more than {MOST_TRIANGLES:,} triangles together; "
                             "choose fewer cells, or one object")
        if found.triangles:
            made[k] = found
    return made


def _required(scene: Scene, made: dict[Key, T]) -> dict[Key, T]:
    if not made:
        raise InputError(f"{scene.name}: no ray can reach what is to be written, so that there is no mesh of it")
    return made


def _meshes(scene: Scene, path: Path, suffix: str, objects: list[int], cells: int) -> tuple[dict[Path, bytes], list[str]]:
    made = _required(scene, _meshed(scene, objects, cells))
    told = [_sentence(scene, k, made.get(k), suffix) for k in objects]
    named = [(f"{k}-{_label(scene, k)}", found) for k, found in made.items()]
    return {path: encoded(suffix, named, [*_about(scene), *told])}, told


def _mitsuba(scene: Scene, path: Path, cells: int) -> tuple[dict[Path, bytes], list[str]]:
    from .mitsuba import files
    from .mitsuba.shapes import native_parts

    native = {k: found for k, obj in enumerate(scene.objects) if (found := native_parts(obj, scene))}
    meshed = [k for k in range(len(scene.objects)) if k not in native]
    made = _meshed(scene, meshed, cells)
    objects = _required(scene, files.shapes(scene, path.stem, made))
    told = [_sentence(scene, k, made.get(k), ".ply") for k in meshed]
    told += [f"object {k} ({_label(scene, k)}): exact; {clipped}" for k, (_, clipped) in native.items() if clipped]
    told.append(files.DIFFERENT)
    about = [*_about(scene), *told, "more samples a pixel: mitsuba -D spp=64 FILE"]
    plys = {path.with_name(files.mesh_file(path.stem, k)):
            encoded(".ply", [(_label(scene, k), found)], [*_about(scene), _sentence(scene, k, found, ".ply")])
            for k, found in made.items()}
    return {path: files.xml(scene, objects, about), **plys}, told


def _povray(scene: Scene, path: Path) -> tuple[dict[Path, bytes], list[str]]:
    from .povray import convert
    from .povray.files import different, file_text

    converted = convert(scene)
    told = [_ascii(line) for line in different(converted)]
    return {path: file_text(converted, _ascii(path.name), [*_about(scene), *told]).encode("ascii")}, told


def _sentence(scene: Scene, k: int, found: Mesh | None, suffix: str) -> str:
    what = f"object {k} ({_label(scene, k)})"
    if found is None:
        return f"{what}: no ray can reach it: left out"
    error = bound(found, suffix)
    far = "how far from the surface is not measurable" if error is None else f"within {rounded_up(error)} of the surface"
    return _ascii(f"{what}: {found.triangles:,} triangles, {far}" + (f"; {found.clipped}" if found.clipped else ""))


def _label(scene: Scene, k: int) -> str:
    """A name that every format can hold: letters, digits, dots, hyphens."""
    return re.sub(r"[^A-Za-z0-9.-]+", "-", scene.objects[k].name).strip("-.")[:60] or scene.objects[k].surface.type


def _about(scene: Scene) -> list[str]:
    return [f"{scene.name} by raytruth {version('raytruth')}", f"scene {scene.hash}"]


def _ascii(text: str) -> str:
    """`text` as one line of printable ASCII: names in it are a scene's, and comments end at lines' ends."""
    return "".join(c if c.isascii() and c.isprintable() else "?" for c in text)
