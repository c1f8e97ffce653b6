"""Reading scene files. They are untrusted: size and nesting are bounded, and every fault is told in one line."""

from __future__ import annotations

import difflib
import itertools
import json
import os
import stat
from pathlib import Path

from pydantic import ValidationError

from ..errors import InputError
from .model import Scene, json_schema

LARGEST_FILE = 1 << 20  # bytes
DEEPEST_NESTING = 32
MOST_FILES = 1000  # of a folder that are asked whether one of them was meant


def load_scene(path: str | Path) -> Scene:
    """The scene in the JSON file `path`.

    Raises InputError: one line that names the file, the place inside it and the remedy.
    """
    source = printable(str(path), longest=200)
    try:
        # without waiting: a named pipe that nobody writes to would keep us for ever
        with open(path, "rb", opener=lambda name, flags: os.open(name, flags | os.O_NONBLOCK)) as file:
            if not stat.S_ISREG(os.fstat(file.fileno()).st_mode):
                raise InputError(f"{source}: is not a regular file; give the path of a scene file")
            data = file.read(LARGEST_FILE + 1)
    except (OSError, ValueError) as error:
        if isinstance(error, InputError):
            raise
        reason = getattr(error, "strerror", None) or error
        close = _nearest_file(Path(path)) if isinstance(error, FileNotFoundError) else None
        raise InputError(f"{source}: cannot be read ({reason}); "
                         + (f"did you mean {close}?" if close else "give the path of a scene file")) from None
    return parse_scene(data, source)


def _nearest_file(path: Path) -> str | None:
    """The scene file beside `path` that somebody may mean by it."""
    beside = itertools.islice(path.parent.glob("*.json"), MOST_FILES)
    close = difflib.get_close_matches(path.name[:100], [file.name for file in beside], 1, 0.7)
    return printable(str(path.with_name(close[0])), longest=200) if close else None


def parse_scene(data: bytes, source: str = "scene") -> Scene:
    """The scene in a JSON document; `source` names it in errors. Raises InputError."""
    if len(data) > LARGEST_FILE:
        raise InputError(f"{source}: is larger than {LARGEST_FILE >> 20} MiB; a scene file is a short JSON document")
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise InputError(f"{source}: is not UTF-8 text (byte {error.start}); save it as UTF-8") from None
    _require_shallow(text, source)
    try:
        document = json.loads(text, object_pairs_hook=_without_repeats, parse_constant=_no_constant)
    except json.JSONDecodeError as error:
        raise InputError(f"{source}: line {error.lineno}, column {error.colno}: is not JSON ({error.msg}); "
                         "correct it there") from None
    except _Refused as error:
        raise InputError(f"{source}: {error}") from None
    except (ValueError, RecursionError):  # an integer of thousands of digits, for one
        raise InputError(f"{source}: holds a number too long to read; write it with at most 17 digits") from None
    if not isinstance(document, dict):
        raise InputError(f'{source}: must be a JSON object {{"camera": ..., "objects": [...], ...}}')
    try:
        scene = Scene.model_validate_json(text.lstrip("\ufeff"))
    except ValidationError as error:
        raise InputError(f"{source}: {one_line(error)}") from None
    try:
        if scene.as_published is not None:
            scene.figure_form()
    except ValidationError as error:
        raise InputError(f"{source}: with as_published: {one_line(error)}") from None
    return scene


class _Refused(Exception):
    pass


def _without_repeats(pairs):
    found = {}
    for key, value in pairs:
        if key in found:
            raise _Refused(f"the key {_quoted(key)} stands twice in one object; keep one of them")
        found[key] = value
    return found


def _no_constant(name):
    raise _Refused(f"holds {name}, which is not JSON and not a number a scene can use; write a finite number")


def _require_shallow(text: str, source: str):
    """Bounds the nesting before any parser recurses over it."""
    depth, in_string, escaped = 0, False, False
    for character in text:
        if in_string:
            if escaped:
                escaped = False
            elif character == "\\":
                escaped = True
            elif character == '"':
                in_string = False
        elif character == '"':
            in_string = True
        elif character in "[{":
            depth += 1
            if depth > DEEPEST_NESTING:
                raise InputError(f"{source}: is nested deeper than {DEEPEST_NESTING} levels; a scene needs about 6")
        elif character in "]}":
            depth -= 1


# --- one sentence for each fault -----------------------------------------------------------------------------------
_KINDS = {"plane", "sphere", "ellipsoid", "torus", "paraboloid", "heart", "expression", "csg"}

_REMEDY = {
    "missing": "is missing; add it",
    "extra_forbidden": "is not a key this place knows; check the spelling or remove it",
    "finite_number": "must be a finite number",
    "float_type": "must be a number",
    "int_type": "must be a whole number",
    "int_from_float": "must be a whole number",
    "int_parsing": "must be a whole number",
    "int_parsing_size": "must be a whole number",
    "float_parsing": "must be a number",
    "bool_parsing": "must be true or false",
    "string_type": "must be text in quotes",
    "string_pattern_mismatch": "must be 1 to 80 lower-case letters, digits, dots and hyphens",
    "tuple_type": "must be a list",
    "model_type": "must be an object in braces",
    "model_attributes_type": "must be an object in braces",
    "union_tag_not_found": 'needs "type": one of plane, sphere, ellipsoid, torus, paraboloid, heart, expression',
    "union_tag_invalid": 'has an unknown "type"; use one of plane, sphere, ellipsoid, torus, paraboloid, heart, expression',
}


def one_line(error: ValidationError) -> str:
    """What is wrong with a scene, where, and what would be right, in one line."""
    faults = error.errors(include_url=False)
    # a list that lost an entry to another fault is not too short on its own account
    faults = [f for f in faults if f["type"] != "too_short"
              or not any(g is not f and g["loc"][:len(f["loc"])] == f["loc"] for g in faults)]
    # a key that is misspelt is missing, too: say what was written, not what was not
    first = next((f for f in faults if f["type"] == "extra_forbidden" and faults[0]["type"] == "missing"
                  and f["loc"][:-1] == faults[0]["loc"][:-1]), faults[0])
    context = first.get("ctx", {})
    kind = first["type"]
    match kind:
        case "value_error":
            remedy = str(context["error"])
        case "greater_than" | "greater_than_equal" | "less_than" | "less_than_equal":
            (word, bound), = context.items()
            sign = {"gt": "greater than", "ge": "at least", "lt": "less than", "le": "at most"}[word]
            remedy = f"must be {sign} {bound:g}"
        case "too_long" if first["loc"] and isinstance(context.get("max_length"), int):
            remedy = f"must have at most {context['max_length']} entries"
        case "too_short":
            remedy = f"must have at least {context['min_length']} entries"
        case "string_too_long":
            remedy = f"must have at most {context['max_length']} characters"
        case "extra_forbidden" if meant := _meant(first, faults):
            remedy = f"is not a key this place knows; did you mean {meant}?"
        case "literal_error":
            remedy = f"must be {context['expected']}"
        case _:
            remedy = _REMEDY.get(kind, first["msg"])
    found = "" if kind in ("missing", "value_error", "extra_forbidden") else f"; found {_quoted(first['input'])}"
    more = f" (and {len(faults) - 1} more)" if len(faults) > 1 else ""
    return " ".join(f"{_place(first['loc'])}: {remedy}{found}{more}".split())


def _meant(fault, faults) -> str | None:
    """The key that a misspelt one stands for: one that is missing beside it, else one that reads like it."""
    place, written = fault["loc"][:-1], str(fault["loc"][-1])
    missing = [f["loc"][-1] for f in faults if f["type"] == "missing" and f["loc"][:-1] == place]
    close = difflib.get_close_matches(written[:40].lower(), missing or _keys_at(place), n=1, cutoff=0.0 if len(missing) == 1
                                      else 0.6)
    return close[0] if close else None


def _keys_at(place) -> list[str]:
    """The keys that the format knows at a place, by its published schema."""
    root = schema = before = json_schema()
    for step in place:
        schema = schema.get("properties", {}).get(step, {}) if isinstance(step, str) else schema.get("items", {})
        options = [schema, *schema.get("anyOf", ()), *schema.get("oneOf", ())]
        if step in _KINDS:  # pydantic inserts the kind of a surface
            schema = before
            options = [{"$ref": schema.get("discriminator", {}).get("mapping", {}).get(step)}]
        before = schema
        for option in options:
            if option.get("$ref"):
                schema = root["$defs"][option["$ref"].rsplit("/", 1)[1]]
    return list(schema.get("properties", ()))


def _place(location) -> str:
    text = ""
    for before, step in zip((None, *location), location):
        if isinstance(step, int):
            text += f"[{step}]"
        elif step not in _KINDS or not (before == "surface" or isinstance(before, int)):  # pydantic inserts the kind
            text += f".{printable(str(step))}" if text else printable(str(step))
    return text or "the scene"


def printable(text: str, longest: int = 60) -> str:
    text = "".join(c if c.isprintable() else "?" for c in text)
    return text if len(text) <= longest else text[:longest] + "..."


def _quoted(value) -> str:
    try:
        return printable(json.dumps(value, default=str, ensure_ascii=False))
    except (ValueError, RecursionError):
        return "something too large to show"
