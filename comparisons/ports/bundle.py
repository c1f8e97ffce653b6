"""The ground truth as files that need nothing of ours: a folder in BagIt layout, and one zip of it.

    bagit.txt, bag-info.txt, manifest-sha256.txt, tagmanifest-sha256.txt
    data/README.md, data/specification/*.md      what to port, and how it is held against what follows
    data/vectors/*.json, *.schema.json           single rays, whole events, small pictures (vectors.py)
    data/scenes/NAME/scene.json, scene.txt       the scene, as JSON and as text
    data/scenes/NAME/LEVEL/planes.json, *.raw    its planes as raw little-endian arrays
    data/scenes/NAME/LEVEL/picture.exr           the same as float channels

`files` lists them all: other programs rely on the names, and a specification's version never changes its list.
"""

from __future__ import annotations

import hashlib
import json
import os
import struct
import zipfile
from collections.abc import Callable, Iterator, Sequence
from functools import cache
from pathlib import Path

import numpy as np

from raytruth import comparisons
from raytruth.converters.plain import plain
from raytruth.reference_tracer.errors import InputError
from raytruth.reference_tracer.scene import library
from raytruth.reference_tracer.scene.model import Scene, json_schema
from raytruth.reference_tracer.tracer.film import HIT, MISS, PLANES, UNDECIDED
from raytruth.reference_tracer.tracer.image_files import save_exr
from raytruth.reference_tracer.tracer.render import Picture

from ..verdicts.conditioning import Limits
from . import vectors
from .cases import Case
from .history import ours
from .protocol import LEVELS, METHODS, PROTOCOL
from .truth import Truths

SPECIFICATION = "1.0.0"
SIZE, SIZES = (96, 72), {4: (48, 36), 16: (24, 18)}  # of a scene's planes, by the samples of a pixel
DOCUMENTS = Path(comparisons.__file__).parents[1] / "docs" / "ports"
TEXTS = ("specification.md", "protocol.md", "port-it-in-an-hour.md")
KINDS = ("surfaces", "events", "switches", "pictures")  # of vectors, a file each
PRECISIONS = (64, 32)
UNITS = {"color": "linear, unclamped", "t": "distance along the ray through the pixel's centre, infinity where nothing is hit",
         "position": "scene units, NaN where nothing is hit", "normal": "unit vector turned against the ray, NaN for none",
         "index": "object in scene order from 0, -1 for none", "depth": "highest generation of secondary rays",
         "status": f"{MISS} nothing is hit, {HIT} hit, {UNDECIDED} the reference itself is undecided: judges nobody",
         "sensitivity64": "what rounding of 53 bits may change of a colour", "sensitivity32": "what rounding of 24 bits may"}


def scenes() -> tuple[Scene, ...]:
    """Every shipped scene, at the size that the bundle has it in."""
    return tuple((s := library.scene(name)).resized(*SIZES.get(s.tracing.samples, SIZE))
                 for name in (*library.effects(), *library.names()))


def files() -> tuple[str, ...]:
    """The payload of a bundle: this list is an interface."""
    planes = [*(f"{name}.raw" for name in (*PLANES, "sensitivity64", "sensitivity32")), "planes.json", "picture.exr"]
    return tuple(sorted((
        "README.md", "versions.json", *(f"specification/{name}" for name in TEXTS), "scene.schema.json", "planes.schema.json",
        *(f"vectors/{kind}.json" for kind in KINDS), "vectors/vectors.schema.json",
        *(f"scenes/{name}/{file}" for name in (*library.effects(), *library.names())
          for file in ("scene.json", "scene.txt", *(f"{level}/{plane}" for level in LEVELS for plane in planes))))))


def write(folder: Path, truths: Truths, told: Callable[[str, float], None] = lambda label, share: None) -> Path:
    """Fills `folder`, which must be new or empty, and makes the zip beside it, which is returned. Raises InputError."""
    if folder.exists() and any(folder.iterdir()):
        raise InputError(f"{folder}: is not empty; name a new folder")
    for name in TEXTS:
        if not (DOCUMENTS / name).exists():
            raise InputError("the specification is not installed with the package; run from a checkout of raytruth")
    data = folder / "data"
    for made, (name, content) in enumerate(_contents(truths), 1):
        path = data / name
        path.parent.mkdir(parents=True, exist_ok=True)
        if isinstance(content, Picture):
            save_exr(content, path)
        else:
            path.write_bytes(content if isinstance(content, bytes) else content.encode())
        told(name, made / len(files()))
    _bag(folder)
    return _zipped(folder)


def _contents(truths: Truths) -> Iterator[tuple[str, str | bytes | Picture]]:
    yield "README.md", README
    yield "versions.json", _json({"specification": SPECIFICATION, "vectors": vectors.VERSION, "protocol": PROTOCOL})
    for name in TEXTS:
        yield f"specification/{name}", (DOCUMENTS / name).read_text(encoding="utf-8")
    yield "scene.schema.json", _json(json_schema())
    yield "planes.schema.json", _json(PLANES_SCHEMA)
    yield "vectors/vectors.schema.json", _json(vectors_schema())
    for kind in KINDS:
        yield f"vectors/{kind}.json", _json(vector_file(kind, truths), indent=None)
    for scene in scenes():
        yield f"scenes/{scene.name}/scene.json", scene.model_dump_json(indent=1, by_alias=True, exclude_none=True) + "\n"
        yield f"scenes/{scene.name}/scene.txt", plain(scene)
        for level in LEVELS:
            yield from _planes(scene, level, truths)


def _json(document, indent: int | None = 1) -> str:
    return json.dumps(document, indent=indent, ensure_ascii=False, allow_nan=False) + "\n"


def _planes(scene: Scene, level: str, truths: Truths) -> Iterator[tuple[str, bytes | str | Picture]]:
    case, where = Case(scene.name, level, scene, "7"), f"scenes/{scene.name}/{level}"
    planes = dict(truths.planes(case))
    picture = Picture(scene=scene, **planes, metadata={"method": METHODS[level], "scene": scene.name})
    for precision in PRECISIONS:
        planes[f"sensitivity{precision}"] = truths.limits(case, precision).color_jump
    listed = []
    for name, array in planes.items():
        array = np.ascontiguousarray(array, array.dtype.newbyteorder("<"))
        listed.append({"name": name, "file": f"{name}.raw", "dtype": array.dtype.name, "byteorder": "little", "offset": 0,
                       "shape": list(array.shape), "order": "C, row 0 at the top", "unit": UNITS[name]})
        yield f"{where}/{name}.raw", array.tobytes()
    yield f"{where}/planes.json", _json({"scene": scene.name, "scene_sha256": scene.hash, "level": level, "planes": listed})
    yield f"{where}/picture.exr", picture


# --- vectors ---------------------------------------------------------------------------------------------------------------
def vector_file(kind: str, truths: Truths) -> dict:
    """All groups of a kind, with what is expected."""
    groups = [group for group in vectors.groups() if group.id.startswith(f"{kind}/")]
    return {"$schema": "vectors.schema.json", "vectors": vectors.VERSION, "specification": SPECIFICATION, "kind": kind,
            "flags": vectors.FLAGS, "groups": [_group(group, truths) for group in groups]}


def _group(group: vectors.Group, truths: Truths) -> dict:
    head = {"id": group.id, "section": group.section, "decisions": list(group.decisions),
            "scene": group.scene.model_dump(mode="json", exclude={"schema_"}, exclude_none=True), "text": plain(group.scene)}
    cases = {level: Case(group.id, level, group.scene, group.section, group.rays) for level in LEVELS}
    planes = {level: truths.planes(case) for level, case in cases.items()}
    limits = {level: {p: truths.limits(case, p) for p in PRECISIONS} for level, case in cases.items()}
    if group.rays is None:
        return {**head, "flags": list(group.flags), "expected": {level: {
            "shape": list(planes[level]["color"].shape), "color": numbers(planes[level]["color"]),
            "index": planes[level]["index"].ravel().tolist(),
            "bounds": {f"fp{p}": {"color": limits[level][p].color_jump.ravel().tolist()} for p in PRECISIONS}}
            for level in LEVELS}}
    rows = []
    for k, vector in enumerate(group.vectors):
        expected = {level: _expected(planes[level], limits[level], k) for level in LEVELS}
        if not group.id.startswith("surfaces/"):
            for level in LEVELS:
                expected[level]["events"] = [r.model_dump(exclude_none=True) for r in _finite(ours(cases[level], k).rays)]
        rows.append({"id": vector.id, "flags": list(vector.flags), "origin": numbers(vector.o), "direction": numbers(vector.d),
                     "truths_differ": _differ(planes, limits, k), "expected": expected})
    return {**head, "vectors": rows}


def _finite(rays: Sequence) -> list:
    return [ray.model_copy(update={name: None for name in ("t", "point", "normal", "color")
                                   if (v := getattr(ray, name)) is not None and not np.isfinite(v).all()}) for ray in rays]


def _expected(planes: dict[str, np.ndarray], limits: dict[int, Limits], k: int) -> dict:
    pick = lambda name: planes[name][0, k]
    found = {"status": ("miss", "hit", "undecided")[int(pick("status"))], "index": int(pick("index")),
             "color": numbers(pick("color"))}
    if pick("index") >= 0:
        found |= {"t": numbers([pick("t")]), "normal": numbers(pick("normal"))}
    names = ("color", "t", "normal") if pick("index") >= 0 else ("color",)
    # where rounding decides which object is hit, how many lights arrive, or whether it is totally reflected
    found["bounds"] = {f"fp{p}": {**{name: float(getattr(found_limits, f"{name}_jump")[0, k]) for name in names},
                                  "rounding_decides": bool(found_limits.risk[0, k])} for p, found_limits in limits.items()}
    return found


def _differ(planes, limits, k: int) -> bool:
    a, b = (planes[level] for level in LEVELS)
    room = sum(limits[level][64].color[0, k] for level in LEVELS)
    there = sum(limits[level][64].t[0, k] for level in LEVELS)
    return bool(a["index"][0, k] != b["index"][0, k] or np.abs(a["color"][0, k] - b["color"][0, k]).max() > room
                or (a["index"][0, k] >= 0 and abs(a["t"][0, k] - b["t"][0, k]) > there))


def numbers(values) -> dict:
    """Numbers as 17 digits, which is what Python writes at most, and as the 64 bits they are, highest first."""
    flat = [float(v) for v in np.ravel(values)]
    return {"values": [float(f"{v:.17g}") for v in flat], "bits": [struct.pack(">d", v).hex() for v in flat]}


# --- schemas ---------------------------------------------------------------------------------------------------------------
_STRINGS = {"type": "array", "items": {"type": "string"}}
_NUMBERS = {"type": "array", "items": {"type": "number"}}
PLANES_SCHEMA = {
    "$schema": "https://json-schema.org/draft/2020-12/schema", "title": "planes of a scene", "type": "object",
    "required": ["scene", "scene_sha256", "level", "planes"], "additionalProperties": False,
    "properties": {
        "scene": {"type": "string"}, "scene_sha256": {"type": "string", "pattern": "^[0-9a-f]{64}$"},
        "level": {"enum": list(LEVELS)},
        "planes": {"type": "array", "items": {
            "type": "object", "additionalProperties": False,
            "required": ["name", "file", "dtype", "byteorder", "offset", "shape", "order", "unit"],
            "properties": {"name": {"type": "string"}, "file": {"type": "string"}, "byteorder": {"const": "little"},
                           "dtype": {"enum": ["float64", "float32", "int32", "uint8"]}, "offset": {"const": 0},
                           "shape": {"type": "array", "items": {"type": "integer"}}, "order": {"type": "string"},
                           "unit": {"type": "string"}}}}}}


@cache
def vectors_schema() -> dict:
    values = {"type": "object", "required": ["values", "bits"], "additionalProperties": False, "properties": {
        "values": _NUMBERS, "bits": {"type": "array", "items": {"type": "string", "pattern": "^[0-9a-f]{16}$"}}}}
    bounds = {"type": "object", "required": ["fp64", "fp32"], "additionalProperties": {"type": "object"}}
    of_ray = {"type": "object", "required": ["status", "index", "color", "bounds"], "properties": {
        "status": {"enum": ["miss", "hit", "undecided"]}, "index": {"type": "integer", "minimum": -1}, "color": values,
        "t": values, "normal": values, "bounds": bounds, "events": {"type": "array", "items": {"type": "object"}}}}
    of_picture = {"type": "object", "required": ["shape", "color", "index", "bounds"]}
    levels = lambda schema: {"type": "object", "required": list(LEVELS), "additionalProperties": schema}
    return {"$schema": "https://json-schema.org/draft/2020-12/schema", "title": "test vectors", "type": "object",
            "required": ["vectors", "specification", "kind", "flags", "groups"],
            "properties": {
                "kind": {"enum": list(KINDS)}, "vectors": {"type": "string"}, "specification": {"type": "string"},
                "flags": {"type": "object", "additionalProperties": {"type": "string"}},
                "groups": {"type": "array", "items": {
                    "type": "object", "required": ["id", "section", "decisions", "scene", "text"], "properties": {
                        "id": {"type": "string"}, "section": {"type": "string"}, "decisions": _STRINGS,
                        "scene": {"type": "object"}, "text": {"type": "string"}, "flags": _STRINGS,
                        "expected": levels(of_picture),
                        "vectors": {"type": "array", "items": {
                            "type": "object", "additionalProperties": False,
                            "required": ["id", "flags", "origin", "direction", "truths_differ", "expected"],
                            "properties": {"id": {"type": "string"}, "flags": _STRINGS, "origin": values, "direction": values,
                                           "truths_differ": {"type": "boolean"}, "expected": levels(of_ray)}}}}}}}}


# --- BagIt (RFC 8493) ------------------------------------------------------------------------------------------------------
def _bag(folder: Path) -> None:
    payload = [folder / "data" / name for name in files()]
    size = sum(path.stat().st_size for path in payload)
    (folder / "bagit.txt").write_text("BagIt-Version: 1.0\nTag-File-Character-Encoding: UTF-8\n")
    (folder / "bag-info.txt").write_text(f"External-Description: ground truth for ray tracers of implicit surfaces\n"
                                         f"External-Identifier: raytruth-{SPECIFICATION}-{vectors.VERSION}\n"
                                         f"Payload-Oxum: {size}.{len(payload)}\n")
    manifest = lambda name, paths: (folder / name).write_text(
        "".join(f"{_sum(path)}  {path.relative_to(folder).as_posix()}\n" for path in paths))
    manifest("manifest-sha256.txt", payload)
    manifest("tagmanifest-sha256.txt", [folder / name for name in ("bagit.txt", "bag-info.txt", "manifest-sha256.txt")])


def _sum(path: Path) -> str:
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def _zipped(folder: Path) -> Path:
    """The same as one file, of the same bytes whenever it is made of the same bytes."""
    target = folder.with_name(folder.name + ".zip")
    part = target.with_name(f".{target.name}.part")
    with zipfile.ZipFile(part, "w", zipfile.ZIP_DEFLATED, compresslevel=6) as archive:
        for path in sorted(p for p in folder.rglob("*") if p.is_file()):
            entry = zipfile.ZipInfo(f"{folder.name}/{path.relative_to(folder).as_posix()}", (1980, 1, 1, 0, 0, 0))
            entry.compress_type, entry.external_attr = zipfile.ZIP_DEFLATED, 0o644 << 16
            archive.writestr(entry, path.read_bytes())
    os.replace(part, target)
    return target


README = """\
# Ground truth for ports of a ray tracer of implicit surfaces

Nothing here needs raytruth: JSON, raw little-endian arrays, OpenEXR. `sha256sum -c manifest-sha256.txt`, in the folder above,
checks that all files are as they were made.

| where | what |
|---|---|
| `specification/` | the tracer to port, complete; the protocol of the checker; how to get there within an hour |
| `vectors/*.json` | rays against single surfaces, whole events with all their rays, pictures of a few pixels |
| `scenes/NAME/` | a scene as JSON and as text, and its planes under both truths |
| `versions.json` | the versions of the specification, the vectors and the protocol, which change apart |

There are two truths: `algorithm` is the method as written, steps and Newton, with its failures; `model` is the same light with
exact intersections. A port that follows the method is held against the first, one with a better root finder against the second.

A vector's numbers come as `values`, which read back exactly, and as `bits`, the 64 bits of each double, highest first.
`bounds` say how far a port may be off that computes in fp64 or fp32: they were measured by moving the reference's own rays by
rounding. Where `rounding_decides`, the bound is as large as the jump. `flags` are explained in each file. An id keeps its
meaning for ever.

A plane is read with `fread`: its shape and type are in `planes.json`, row 0 is the top. `sensitivity64` and
`sensitivity32` say for every pixel what rounding may change of its colour; pixels whose `status` is 2 judge nobody.
"""
