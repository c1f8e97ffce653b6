"""Meshes as other programs open them: as objects of trimesh, and as PLY, OBJ, STL and glTF files.

A file tells how far its triangles are from the surfaces wherever its format has a place for words. Coordinates are the
scene's own. PLY, STL and glTF hold single precision, and what that moves a vertex by counts as error of the mesh.
"""

from __future__ import annotations

import io
from collections.abc import Sequence
from decimal import ROUND_CEILING, Decimal
from typing import TYPE_CHECKING, Any

import numpy as np

from .mesh import Mesh

if TYPE_CHECKING:
    import trimesh

SUFFIXES = (".ply", ".obj", ".stl", ".glb")
SINGLE = 2.0**-24  # relative: what a coordinate moves by when it is rounded to single precision
STL_HEADER = 80  # bytes


def as_trimesh(mesh: Mesh, **facts: Any) -> trimesh.Trimesh:
    """`mesh` in fp64 with its vertex normals; `facts` and its error, in the scene's unit, are its metadata."""
    import trimesh

    return trimesh.Trimesh(mesh.vertices, mesh.faces, vertex_normals=mesh.normals, process=False, validate=False, metadata={
        **facts, "error_bound": mesh.error, "cells": mesh.resolution, "clipped": mesh.clipped})


def bound(mesh: Mesh, suffix: str) -> float | None:
    """How far triangles of `mesh` in a file that ends in `suffix` are from the surface, at most; None: not measurable.

    Rounding moves no point of a triangle further than the corner that it moves furthest.
    """
    if mesh.error is None or suffix == ".obj":
        return mesh.error
    return mesh.error + SINGLE * float(np.linalg.norm(mesh.vertices, axis=1).max(initial=0.0))


def rounded_up(error: float) -> str:
    """`error` in two digits, never a smaller number."""
    digits = Decimal(error)
    return f"{float(digits.quantize(Decimal((0, (1,), digits.adjusted() - 1)), ROUND_CEILING)) if error else 0:g}"


def encoded(suffix: str, meshes: Sequence[tuple[str, Mesh]], about: Sequence[str]) -> bytes:
    """The bytes of a file of `meshes`, by their names; `about` are lines of printable ASCII that it tells of itself.

    PLY and STL have no objects: theirs are one mesh. STL has normals of facets only, and room for one short line.
    """
    from trimesh.exchange import gltf, ply, stl

    match suffix:
        case ".obj":
            return _obj(meshes, about)
        case ".glb":
            scene = _scene(meshes)
            scene.metadata["about"] = list(about)
            return bytes(gltf.export_glb(scene, include_normals=True))
        case ".ply":
            head, body = ply.export_ply(_joined(meshes), vertex_normal=True).split(b"end_header\n", 1)
            lines = [line for line in head.decode("ascii").splitlines() if not line.startswith("comment")]
            return "\n".join([*lines[:2], *(f"comment {line}" for line in about), *lines[2:], "end_header\n"]).encode() + body
        case ".stl":
            header = "; ".join([*about[:1], *_largest(meshes, suffix)]).encode("ascii")[:STL_HEADER].ljust(STL_HEADER)
            return bytes(header + stl.export_stl(_joined(meshes))[STL_HEADER:])
    raise ValueError(f"{suffix} is none of {', '.join(SUFFIXES)}")


def _obj(meshes: Sequence[tuple[str, Mesh]], about: Sequence[str]) -> bytes:
    """trimesh's own writer drops the normals of a scene's objects."""
    text, before = io.BytesIO(), 0
    write = lambda word, rows: np.savetxt(text, rows, f"{word} %.17g %.17g %.17g")  # fp64 in full
    text.write("".join(f"# {line}\n" for line in about).encode("ascii"))
    for name, mesh in meshes:
        text.write(f"o {name}\n".encode("ascii"))
        write("v", mesh.vertices)
        write("vn", mesh.normals)
        np.savetxt(text, np.repeat(mesh.faces + 1 + before, 2, axis=1), "f %d//%d %d//%d %d//%d")
        before += len(mesh.vertices)
    return text.getvalue()


def _scene(meshes: Sequence[tuple[str, Mesh]]) -> trimesh.Scene:
    import trimesh

    scene = trimesh.Scene()
    for name, mesh in meshes:
        shape = as_trimesh(mesh)
        shape.metadata["error_bound"] = bound(mesh, ".glb")  # of what the file holds
        scene.add_geometry(shape, node_name=name, geom_name=name)
    return scene


def _joined(meshes: Sequence[tuple[str, Mesh]]) -> trimesh.Trimesh:
    import trimesh

    parts = [mesh for _, mesh in meshes]
    before = np.cumsum([0, *(len(mesh.vertices) for mesh in parts[:-1])])
    join = lambda arrays: np.concatenate(list(arrays))
    return trimesh.Trimesh(join(mesh.vertices for mesh in parts), join(mesh.faces + n for mesh, n in zip(parts, before)),
                           vertex_normals=join(mesh.normals for mesh in parts), process=False, validate=False)


def _largest(meshes: Sequence[tuple[str, Mesh]], suffix: str) -> list[str]:
    from .error import largest

    error = largest(bound(mesh, suffix) for _, mesh in meshes)
    return ["error not measurable" if error is None else f"within {rounded_up(error)} of the surface"]
