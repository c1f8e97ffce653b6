"""Scene files are untrusted: what is wrong with one is told in one line that names file, place and remedy."""

import json
import time

import pytest

from raytruth.reference_tracer.errors import InputError
from raytruth.reference_tracer.scene import library
from raytruth.reference_tracer.scene.load import LARGEST_FILE, load_scene, parse_scene
from raytruth.reference_tracer.scene.model import LONGEST_SIDE, Scene, Tracing, json_schema

BALL = {"surface": {"type": "sphere", "center": [0, 0, 5], "r": 1}}
GOOD = {"name": "good", "camera": {"width": 8, "height": 6}, "objects": [BALL], "lights": [{"position": [0, 3, 0]}],
        "background": [0, 0, 0], "tracing": {"step_size": 0.1}}


def changed(path: str, value) -> bytes:
    """GOOD with one value replaced; `path` as errors write it, e.g. objects[0].surface.r."""
    document = json.loads(json.dumps(GOOD))
    place = document
    *steps, last = path.replace("[", ".").replace("]", "").split(".")
    for step in steps:
        place = place[int(step) if step.isdigit() else step] if step.isdigit() else place.setdefault(step, {})
    place[int(last) if last.isdigit() else last] = value
    return json.dumps(document).encode()


def surface(**fields) -> tuple[str, bytes]:
    return "objects[0].surface", changed("objects[0].surface", fields)


def raw(text: str | bytes) -> tuple[str, bytes]:
    return "", text if isinstance(text, bytes) else text.encode()


def place(path: str, value, named: str | None = None) -> tuple[str, bytes]:
    return path if named is None else named, changed(path, value)


# name: (the place the error has to name, the file)
MALFORMED = {
    "empty file": raw(""), "not JSON": raw("camera: 3"), "half a document": raw('{"objects": ['),
    "a trailing comma": raw('{"a": 1,}'),
    "a list": raw("[1, 2]"), "a number": raw("3"), "null": raw("null"), "two documents": raw("{} {}"),
    "not UTF-8": raw(b'{"name": "\xff\xfe"}'), "UTF-16": raw('{"objects": []}'.encode("utf-16")),
    "a lone surrogate": raw('{"name": "\\ud800", "objects": []}'), "too large": raw(" " * (LARGEST_FILE + 1)),
    "deep lists": raw('{"objects": ' + "[" * 5000 + "]" * 5000 + "}"),
    "deep objects": raw('{"a":' * 100 + "1" + "}" * 100),
    "NaN": raw('{"objects": [], "background": [NaN, 0, 0]}'),
    "Infinity": raw('{"objects": [], "background": [0, -Infinity, 0]}'),
    "a number of 5000 digits": raw('{"format": ' + "9" * 5000 + "}"),
    "a repeated key": raw('{"name": "a", "name": "b", "objects": []}'),
    "a repeated key within": raw('{"objects": [{"surface": {"type": "sphere", "r": 1, "r": 2}}]}'),
    "no objects": ("objects", json.dumps({"name": "x"}).encode()), "empty objects": place("objects", []),
    "objects is an object": place("objects", {}), "an object is a text": place("objects[0]", "ball"),
    "no surface": ("objects[0].surface", changed("objects[0]", {"material": {}})),
    "unknown surface": surface(type="teapot", r=1), "surface without type": surface(r=1),
    "type is a number": surface(type=3, r=1),
    "no radius": ("objects[0].surface.r", surface(type="sphere")[1]),
    "a negative radius": place("objects[0].surface.r", -1), "a zero radius": place("objects[0].surface.r", 0),
    "a radius in quotes": place("objects[0].surface.r", "1"), "a true radius": place("objects[0].surface.r", True),
    "an infinite radius": ("objects[0].surface.r", changed("objects[0].surface.r", 77).replace(b"77", b"1e999")),
    "a huge radius": place("objects[0].surface.r", 1e300),
    "a centre in two numbers": place("objects[0].surface.center", [0, 0]),
    "a centre in four": place("objects[0].surface.center", [0, 0, 0, 0]),
    "a centre that is null": place("objects[0].surface.center", None),
    "an unknown parameter": ("objects[0].surface.R", surface(type="sphere", r=1, R=2)[1]),
    "an unknown key called like a kind": ("objects[0].surface.sphere", surface(type="sphere", r=1, sphere=2)[1]),
    "a plane without normal": ("objects[0].surface", surface(type="plane", a=0, b=0, c=0)[1]),
    "inside is a word": place("objects[0].surface.inside", "yes"),
    "a rotation without axis": ("objects[0].rotation.axis", changed("objects[0].rotation", {"degrees": 3})),
    "a zero axis": ("objects[0].rotation", changed("objects[0].rotation", {"axis": [0, 0, 0], "degrees": 3})),
    "a formula that calls": ("objects[0].surface.formula",
                             surface(type="expression", formula="__import__('os').system('x')")[1]),
    "a formula that is none": ("objects[0].surface.formula", surface(type="expression", formula="x +")[1]),
    "a formula of a number": ("objects[0].surface.formula", surface(type="expression", formula=3)[1]),
    "a formula too long": ("objects[0].surface.formula", surface(type="expression", formula="x+" * 5000 + "x")[1]),
    "bounds in disorder": ("objects[0].surface.bounds", surface(type="expression", formula="x",
                                                                bounds={"low": [1, 0, 0], "high": [0, 1, 1]})[1]),
    "a colour above one": ("objects[0].material.color[1]", changed("objects[0].material", {"color": [0, 1.5, 0]})),
    "reflection below zero": ("objects[0].material.reflection", changed("objects[0].material", {"reflection": -0.1})),
    "a refractive index of zero": ("objects[0].material.refractive_index",
                                   changed("objects[0].material", {"refractive_index": 0})),
    "an unknown material key": ("objects[0].material.colour", changed("objects[0].material", {"colour": [1, 1, 1]})),
    "too many objects": ("objects", json.dumps({"objects": [BALL] * 1025}).encode()),
    "a huge picture": place("camera.width", 10 * LONGEST_SIDE),
    "too many pixels": ("camera", changed("camera", {"width": LONGEST_SIDE, "height": LONGEST_SIDE})),
    "no pixel": place("camera.height", 0), "half a pixel": place("camera.width", 8.5),
    "pixels in quotes": place("camera.width", "8"),
    "a zero direction": ("camera", changed("camera.direction", [0, 0, 0])),
    "a zero up": ("camera", changed("camera.up", [0, 0, 0])),
    "up along the direction": ("camera", changed("camera.up", [0, 0, -2])), "180 degrees": place("camera.fov", 180),
    "a light without position": ("lights[0].position", changed("lights[0]", {"brightness": [1, 1, 1]})),
    "a negative light": ("lights[0].brightness[2]", changed("lights[0].brightness", [1, 1, -1])),
    "a background in quotes": place("background", "black"), "an endless background": place("background[0]", 1e9),
    "no step": place("tracing.step_size", 0),
    "a million steps and more": ("tracing", changed("tracing.step_size", 1e-6)),
    "a depth of a thousand": place("tracing.max_depth", 1000), "too many samples": place("tracing.samples", 33),
    "an unknown law": place("tracing.refraction", "fresnel"), "an unknown key": place("lamps", []),
    "a key of control characters": ("?", changed("a\nb\u2028c\x1b[31m", 1)),
    "a name with spaces": place("name", "my scene"),
    "a name that is a path": place("name", "../../etc/passwd"), "another format": place("format", 2),
    "a long title": place("title", "x" * 201),
}


def test_there_are_more_than_thirty_of_them_and_the_original_is_good():
    assert len(MALFORMED) >= 30
    assert parse_scene(json.dumps(GOOD).encode()).name == "good"


@pytest.mark.parametrize("name", MALFORMED)
def test_a_malformed_file_is_told_in_one_line(name, tmp_path):
    where, data = MALFORMED[name]
    path = tmp_path / "broken.json"
    path.write_bytes(data)
    with pytest.raises(InputError) as error:
        load_scene(path)
    message = str(error.value)
    assert message.startswith(f"{path}: ") and where in message.removeprefix(str(path))
    assert len(message.splitlines()) == 1 and message.isprintable() and 20 < len(message) - len(str(path)) < 400
    assert error.value.__context__ is None or error.value.__suppress_context__


@pytest.mark.parametrize("make", ["missing", "a directory", "under a file"])
def test_what_is_no_file_is_told_in_one_line(make, tmp_path):
    path = {"missing": tmp_path / "none.json", "a directory": tmp_path,
            "under a file": tmp_path / "file" / "scene.json"}[make]
    (tmp_path / "file").touch()
    with pytest.raises(InputError) as error:
        load_scene(path)
    assert str(error.value).startswith(f"{path}: ") and len(str(error.value).splitlines()) == 1


@pytest.mark.parametrize("data", [b"{" + b",".join(b'"%d":1' % k for k in range(20_000)) + b"}", b"[" * LARGEST_FILE],
                         ids=["20000 keys", "a megabyte of brackets"])
def test_large_files_are_refused_quickly(data):
    """Reading takes time in proportion to the file: these take well under a second, quadratic work takes many."""
    start = time.process_time()
    with pytest.raises(InputError):
        parse_scene(data)
    assert time.process_time() - start < 2


@pytest.mark.parametrize("name", ["", "figure-99", "no-such-scene", "/no/such/file.json"])
def test_unknown_scenes_are_told(name):
    with pytest.raises(InputError) as error:
        library.find(name)
    assert len(str(error.value).splitlines()) == 1


def test_a_byte_order_mark_is_accepted():
    assert parse_scene(b"\xef\xbb\xbf" + json.dumps(GOOD).encode()).name == "good"


def test_numbers_may_be_written_as_whole_numbers_or_not():
    assert parse_scene(changed("objects[0].surface.r", 2)).objects[0].surface.r == 2.0


def test_a_scene_written_back_is_the_same_scene():
    for scene in (parse_scene(json.dumps(GOOD).encode()), library.scene(library.names()[-1])):
        again = parse_scene(scene.model_dump_json(by_alias=True).encode())
        assert again == scene and again.hash == scene.hash


def test_the_hash_tells_pictures_apart_and_nothing_else():
    scene = parse_scene(json.dumps(GOOD).encode())
    for path, value in (("objects[0].surface.r", 1.0000001), ("tracing.max_depth", 7), ("background[0]", 0.1),
                        ("camera.width", 9)):
        assert parse_scene(changed(path, value)).hash != scene.hash
    for path, value in (("name", "other"), ("title", "t"), ("description", "d"), ("objects[0].name", "n"),
                        ("estimates", "e")):
        assert parse_scene(changed(path, value)).hash == scene.hash


# --- the published schema and the shipped scenes -------------------------------------------------------------------
def conforms(value, schema: dict, root: dict) -> bool:
    """The part of JSON Schema that the published one uses, read as its specification says."""
    if "$ref" in schema:
        return conforms(value, root["$defs"][schema["$ref"].rsplit("/", 1)[1]], root)
    if any(key in schema for key in ("anyOf", "oneOf")):
        return any(conforms(value, option, root) for option in schema.get("anyOf", schema.get("oneOf")))
    if "const" in schema or "enum" in schema:
        return value in schema.get("enum", [schema.get("const")])
    match schema["type"]:
        case "object":
            known = schema.get("properties", {})
            return (isinstance(value, dict) and set(schema.get("required", [])) <= set(value)
                    and (schema.get("additionalProperties", True) is not False or set(value) <= set(known))
                    and all(conforms(v, known[k], root) for k, v in value.items() if k in known))
        case "array":
            if not isinstance(value, list):
                return False
            items = schema.get("prefixItems", [schema.get("items", {})] * len(value))
            return (schema.get("minItems", 0) <= len(value) <= schema.get("maxItems", len(value))
                    and all(conforms(v, s, root) for v, s in zip(value, items)))
        case "number" | "integer" as kind:
            return (isinstance(value, int if kind == "integer" else (int, float)) and not isinstance(value, bool)
                    and value >= schema.get("minimum", value) and value <= schema.get("maximum", value)
                    and value > schema.get("exclusiveMinimum", value - 1)
                    and value < schema.get("exclusiveMaximum", value + 1))
        case kind:
            return isinstance(value, {"string": str, "boolean": bool, "null": type(None)}[kind])


@pytest.mark.parametrize("name", library.names())
def test_shipped_scenes_are_valid_and_bear_the_name_of_their_file(name):
    scene = library.find(name)
    assert isinstance(scene, Scene) and scene.name == name and scene.title and scene.figure and scene.description
    document = json.loads(scene.model_dump_json(by_alias=True, exclude_unset=True))
    assert conforms(document, json_schema(), json_schema())


@pytest.mark.parametrize("name", library.names())
def test_S1_shipped_scenes_mark_their_estimates(name):
    """No figure prints positions, colours, lights or steps: every scene file says which of its values are estimates."""
    assert len(library.scene(name).estimates) > 20


def test_the_schema_refuses_what_the_reader_refuses():
    schema = json_schema()
    assert schema["$schema"].endswith("2020-12/schema") and conforms(GOOD, schema, schema)
    for name in ("empty objects", "no radius", "a negative radius", "a radius in quotes", "an unknown key",
                 "a huge picture",
                 "half a pixel", "an unknown law", "a colour above one", "unknown surface", "a centre in four"):
        assert not conforms(json.loads(MALFORMED[name][1]), schema, schema), name


# --- as_published --------------------------------------------------------------------------------------------------
def published(patch) -> bytes:
    return json.dumps({**GOOD, "camera": {"width": 8, "height": 6, "fov": 40, "v_x": [1, 0, 0]},
                       "as_published": patch}).encode()


def test_as_published_is_a_merge_patch_of_the_scene():
    """RFC 7386: keys are merged, null removes, lists are replaced."""
    scene = parse_scene(published({"camera": {"v_x": None, "width": 4}, "lights": [], "tracing": {"lights": "balanced"}}))
    figure = scene.figure_form()
    assert (figure.camera.v_x, figure.camera.width, figure.camera.height, figure.camera.fov) == (None, 4, 6, 40)
    assert figure.lights == () and figure.tracing.lights == "balanced" and figure.tracing.step_size == 0.1
    assert figure.objects == scene.objects and figure.as_published is None and figure.name == "good-as-published"
    assert scene.camera.width == 8 and len(scene.lights) == 1 and scene.tracing.lights == "sum"  # the text's form stays


def test_the_text_s_form_is_hashed_without_as_published():
    plain = parse_scene(json.dumps({**GOOD, "camera": {"width": 8, "height": 6, "fov": 40, "v_x": [1, 0, 0]}}).encode())
    nothing, other = parse_scene(published({})), parse_scene(published({"tracing": {"ambient": 0.1}}))
    assert plain.hash == nothing.hash == other.hash == nothing.figure_form().hash != other.figure_form().hash
    with pytest.raises(InputError, match="as_published"):
        plain.figure_form()


def test_as_published_outlives_writing_and_reading():
    scene = parse_scene(published({"camera": {"v_x": None}, "lights": []}))
    again = parse_scene(scene.model_dump_json(by_alias=True).encode())
    assert again == scene and again.figure_form() == scene.figure_form() and hash(again) == hash(scene)


@pytest.mark.parametrize("patch, word", [
    (3, "as_published: must be an object"), ({"name": "x"}, "as_published.name"), ({"camera": 3}, "as_published.camera"),
    ({"camera": {"fov": 200}}, "with as_published: camera.fov: must be less than 180"),
    ({"objects": []}, "with as_published: objects"), ({"objects": None}, "with as_published: objects: is missing"),
    ({"tracing": {"light": "sum"}}, "tracing.light: is not a key this place knows; did you mean lights"),
    ({"objects": [{"surface": {"type": "sphere", "r": -1}}]}, r"with as_published: objects\[0\].surface.r")])
def test_a_patch_that_makes_no_scene_is_refused_in_one_line(patch, word):
    with pytest.raises(InputError, match=word) as error:
        parse_scene(published(patch))
    assert "\n" not in str(error.value)


@pytest.mark.parametrize("name", library.names())
def test_every_figure_has_its_form(name):
    """Of figures 1 to 4 it is the text's; of no other."""
    text, figure = library.scene(name), library.find(f"{name}@published")
    assert (text.hash == figure.hash) == (text.figure in {f"Figure {k}" for k in range(1, 5)})
    assert (text.camera.width, text.camera.height) == (figure.camera.width, figure.camera.height)
    default = Tracing()
    assert all(getattr(text.tracing, switch) == getattr(default, switch) for switch in ("lights", "ambient", "shadows", "range"))
