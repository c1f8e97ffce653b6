"""Hostile inputs of the command line: input k of a seed is always the same one, and needs none of the others.

They come from a generator of our own: a property-based testing library makes an input depend on those before it, and what
is needed here is that one number brings back one input.
"""

from __future__ import annotations

import json
import os
import random
from dataclasses import dataclass, field
from pathlib import Path

from raytruth.cli import COMMANDS
from raytruth.reference_tracer.scene import library

LENGTHS = ("compare", "transport", "stability", "chart", "plan", "attribute", "report", "doctor")  # take long when all is well

GOOD = {"name": "good", "camera": {"width": 8, "height": 6}, "background": [0.1, 0.2, 0.3],
        "objects": [{"surface": {"type": "sphere", "center": [0, 0, 5], "r": 1}, "material": {"reflection": 0.2}},
                    {"surface": {"type": "plane", "center": [0, -1, 0], "a": 0, "b": 1, "c": 0}},
                    {"surface": {"type": "expression", "formula": "x**4+y**4+z**4-1", "center": [1, 0, 4],
                                 "bounds": {"low": [-1, -1, -1], "high": [1, 1, 1]}},
                     "rotation": {"axis": [0, 1, 0], "degrees": 30}}],
        "lights": [{"position": [0, 3, 0], "brightness": [1, 1, 1]}],
        "tracing": {"step_size": 0.1, "max_depth": 3, "samples": 1}}

NUMBERS = (0, -0.0, 1, -1, 1e-300, 1e300, 1e-6, 1e6, 1e7, -1e6, 2**31, 2**63, 10**400, 1.5, 1e-16, 0.1, 64, 65, 1024, 1e999,
           -1e999, 16384, 16385, 180, 179.999999, 1e-9)
TEXTS = ("", "x", "\x00", "\ud800", "\u202e", "ß" * 300, "\U0001f525", "sphere", "torus", "NaN", "../../etc/passwd", "\n", "x" * 3000,
         "1e5", "null", "\u0661\u0662", "{}", "__import__('os')", "-1")
WORDS = ("", "abc", "-1", "0", "1e9", "nan", "NaN", "inf", "-inf", "9" * 5000, "1e400", "0x10", "٣", " ", "--", "½", "1_000",
         "None", "true", "\x00", "\n", "x" * 4000, "../..", "3.5", "1,2", "💥", "\udcff")
SIZES = ("0x0", "-1x5", "1e9x1e9", "0x5", "5x0", "x", "5x", "99999x99999", "9" * 30 + "x1", "8x6x4", "٣x٣", "8X6", "1.5x2", "²x2",
         "16384x16384", "nanxnan", "8 x 6", "+8x6")


@dataclass
class Input:
    """One call of the command line. `files` are made in its folder before it, named pipes from None."""

    number: int
    kind: str
    arguments: list[str]
    files: dict[str, bytes | None] = field(default_factory=dict)
    must_fail: bool = False  # bad for sure: exit code 2 and one sentence

    def lay(self, folder: Path) -> list[str]:
        """Makes the files in `folder`; the arguments that name them there."""
        for name, content in self.files.items():
            path = folder / name
            path.unlink(missing_ok=True)
            if content is None:
                os.mkfifo(path)
            else:
                path.write_bytes(content)
        return [argument.replace("{dir}", str(folder)) for argument in self.arguments]


def make(seed: int, number: int) -> Input:
    """Input `number` of `seed`."""
    chance = random.Random(f"{seed}/{number}")
    kind = chance.choices((torn, mutated, formulas, extreme, options), weights=(24, 28, 16, 2, 30))[0]
    made = kind(chance)
    made.number, made.kind = number, kind.__name__
    return made


# --- scene files ---------------------------------------------------------------------------------------------------
def torn(chance: random.Random) -> Input:
    """The bytes of a good scene, damaged."""
    text = bytearray(json.dumps(_document(chance)).encode())
    for _ in range(chance.choice((1, 1, 2, 8))):
        at = chance.randrange(len(text) + 1)
        match chance.randrange(7):
            case 0:
                del text[at:]
            case 1:
                text[at:at] = bytes(chance.randrange(256) for _ in range(chance.choice((1, 4))))
            case 2:
                del text[at:at + chance.randrange(1, 30)]
            case 3:
                text[at:at] = chance.choice((b"[", b"{", b'"', b"\\u", b"[" * 40, b"{\"a\":" * 500, b"[" * 100_000))
            case 4:
                text[at:at] = text[max(0, at - chance.randrange(1, 200)):at]
            case 5:
                text[:0] = chance.choice((b"\xef\xbb\xbf", b"\xff\xfe", b"\x00", b"//", b" " * 2**20))
            case 6:
                text[at:at] = chance.choice((b"9" * 5000, b"1e" + b"9" * 400, b"NaN", b"-", b"0.", b"1" * 300 + b"e-300"))
        if not text:
            break
    return _checked("torn.json", bytes(text))


def mutated(chance: random.Random) -> Input:
    """A good scene with values, keys or types exchanged."""
    document = _document(chance)
    for _ in range(chance.choice((1, 1, 1, 2, 5))):
        _mutate(document, chance)
    text = json.dumps(document)
    if chance.random() < 0.1:  # a key twice
        text = text.replace('"camera"', '"camera": {}, "camera"', 1)
    data = text.encode("utf-8", "surrogatepass")
    return _rendered("mutated.json", data, chance) if chance.random() < 0.12 else _checked("mutated.json", data)


def formulas(chance: random.Random) -> Input:
    """A surface of a random formula: well formed or not."""
    if chance.random() < 0.4:
        alphabet = ["x", "y", "z", "pi", "+", "-", "*", "/", "**", "(", ")", "sqrt", "log", "min", ",", ".", "1", "e", "2", "0", " ",
                    "[", "lambda", ":", "=", "\\", "'", "x²", "%", "//", "if", "@", "\n", "#", "9" * 40, "1e308", "1e-320"]
        text = "".join(chance.choice(alphabet) for _ in range(chance.choice((1, 3, 8, 20, 300))))
    else:
        text = _formula(chance, chance.choice((1, 2, 3, 4, 5)))
    surface = {"type": "expression", "formula": text, "center": [0, 0, chance.choice((3, 0, 1e5))]}
    if chance.random() < 0.5:
        surface["bounds"] = {"low": [-2, -2, -2], "high": [2, 2, 2]}
    document = {"camera": {"width": 6, "height": 4}, "objects": [{"surface": surface}], "lights": [{"position": [1, 2, 0]}]}
    data = json.dumps(document).encode()
    return _rendered("formula.json", data, chance) if chance.random() < 0.25 else _checked("formula.json", data)


def extreme(chance: random.Random) -> Input:
    """A valid scene at the ends of what the format allows."""
    far = lambda: chance.choice((0.0, 1e-6, 1.0, -3.0, 1e3, 1e6, -1e6))
    part = lambda: chance.choice((0.0, 1e-300, 0.5, 1.0))
    length = lambda: chance.choice((2e-6, 0.01, 1.0, 30.0, 1e6))
    objects = []
    for _ in range(chance.choice((1, 1, 2, 3, 20))):
        surface = chance.choice((
            {"type": "sphere", "r": length()}, {"type": "plane", "a": far(), "b": 1.0, "c": far()},
            {"type": "torus", "R": length(), "r": length()}, {"type": "heart"},
            {"type": "expression", "formula": chance.choice(("x*1e300", "x**32+y**32+z**32-1", "sin(1e9*x)", "1e-300*(x*x+y*y-1)",
                                                             "exp(x*100)-1", "log(x)", "z/x", "abs(x)**0.5-y"))}))
        objects.append({"surface": surface | {"center": [chance.choice((0.0, far())), 0.0, chance.choice((4.0, far()))]},
                        "material": {"reflection": part(), "transparency": part(),
                                     "refractive_index": chance.choice((0.1, 1.0, 1.5, 10.0))}})
    side = lambda: chance.choice((1, 2, 7, 16))
    document = {"camera": {"width": side(), "height": side(), "fov": chance.choice((1e-9, 60, 179.999999)),
                           "position": [far(), far(), far()]},
                "objects": objects, "lights": [{"position": [far(), far(), far()], "brightness": [1000.0, 0.0, 1.0]}],
                "background": [1000.0, 0.0, 1e-300],
                "tracing": {"max_depth": chance.choice((0, 1, 8, 64)), "samples": chance.choice((1, 1, 2)),
                            "max_distance": chance.choice((2e-6, 30.0, 1e3)), "step_size": chance.choice((0.1, 1e-2, 1000.0)),
                            "tolerance": chance.choice((1e-15, 1.0)), "max_iterations": chance.choice((1, 1000)),
                            "cutoff": chance.choice((0.0, 1.0)), "adaptive": chance.choice((0.0, 0.5, 1.0))}}
    if chance.random() < 0.15:
        document["camera"] |= {"width": 16384, "height": chance.choice((4096, 512, 64))}
    axis = lambda: chance.choice(([0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [far(), far(), far()], [0.0, -1e-5, 0.0]))
    document["camera"] |= {name: axis() for name in ("direction", "up", "v_x", "v_y") if chance.random() < 0.2}
    document["tracing"] |= {"lights": chance.choice(("sum", "balanced")), "ambient": chance.choice((0.0, 1e-300, 1000.0)),
                            "shadows": chance.choice(("attenuate", "opaque_only")), "range": chance.choice(("ray", "path"))}
    return _rendered("extreme.json", json.dumps(document).encode(), chance)


def _document(chance: random.Random) -> dict:
    if chance.random() < 0.7:
        return json.loads(json.dumps(GOOD))
    scene = library.scene(chance.choice(library.names() + library.effects()))
    return json.loads(scene.resized(6, 4).model_dump_json(by_alias=True, exclude_none=True))


def _mutate(document, chance: random.Random) -> None:
    place = document
    while True:  # to a random container
        inner = [value for value in (place.values() if isinstance(place, dict) else place) if isinstance(value, (dict, list))]
        if not inner or chance.random() < 0.25:
            break
        place = chance.choice(inner)
    keys = list(place) if isinstance(place, dict) else list(range(len(place)))
    key = chance.choice(keys) if keys else None
    value = chance.choice((None, True, [], {}, chance.choice(NUMBERS), chance.choice(NUMBERS), chance.choice(TEXTS),
                           [chance.choice(NUMBERS)] * 3, [[]] * 50, _deep(chance.choice((5, 40, 3000)))))
    match chance.randrange(6):
        case 0 | 1 | 2 if keys:
            place[key] = value
        case 3 if keys:
            del place[key]
        case 4 if isinstance(place, dict) and keys:  # misspelt
            at = chance.randrange(len(key) + 1)
            place[key[:at] + chance.choice(("", "x", "_", "\u200b")) + key[at + 1:]] = place.pop(key)
        case _:
            place.update({chance.choice(TEXTS): value}) if isinstance(place, dict) else place.extend([value] * chance.choice((1, 2000)))


def _deep(levels: int):
    """Nested lists, made without recursion; JSON's writer recurses, so that no more than it bears."""
    value = []
    for _ in range(min(levels, 400)):
        value = [value]
    return value


def _formula(chance: random.Random, depth: int) -> str:
    if depth == 0 or chance.random() < 0.1:
        return chance.choice(("x", "y", "z", "x", "y", "z", "1", "0", "2.5", "pi", "1e300", "1e-300", "-3"))
    inner = lambda: _formula(chance, depth - 1)
    match chance.randrange(5):
        case 0 | 1:
            return f"({inner()}{chance.choice('+-*/')}{inner()})"
        case 2:
            return f"({inner()})**{chance.choice(('2', '3', '0.5', '-1', '2.5', '32', '33', '0', 'x', '1e9'))}"
        case 3:
            return f"{chance.choice(('sqrt', 'cbrt', 'sin', 'cos', 'tan', 'exp', 'log', 'abs'))}({inner()})"
        case _:
            return f"{chance.choice(('min', 'max'))}({inner()},{inner()})"


def _checked(name: str, data: bytes) -> Input:
    return Input(0, "", ["scenes", f"{{dir}}/{name}"], {name: data})


def _rendered(name: str, data: bytes, chance: random.Random) -> Input:
    if chance.random() < 0.15:
        ending = chance.choice((".ply", ".obj", ".stl", ".glb", ".xml", ".pov", ".txt"))
        return Input(0, "", ["export", f"{{dir}}/{name}", "-o", f"{{dir}}/out{ending}", "--cells=8"], {name: data})
    suffix = chance.choice((".png", ".npz", ".exr"))
    method = chance.choice((["--method", "paper"], ["--method", "interval"], [], [], [], ["--method", "descartes"],
                            ["--precision", "32"], ["--method", "proof"]))
    return Input(0, "", ["render", f"{{dir}}/{name}", "-o", f"{{dir}}/out{suffix}", *method], {name: data})


# --- options -------------------------------------------------------------------------------------------------------
NUMERIC = {  # options with a number, for each command; every one of BAD_NUMBERS is wrong for every one of them
    "render": ["--samples", "--step-size", "--threads", "--memory"], "certify": ["--sample", "--paths", "--threads"],
    "sensitivity": ["--verify"], "compare": ["--largest", "--limit", "--jobs"], "transport": ["--limit", "--jobs"],
    "chart": ["--turns", "--limit"], "plan": ["--tolerance", "--limit"], "stability": ["--rays"], "attribute": ["--jobs"],
    "export": ["--cells"], "bench": ["--turns", "--limit"]}
BAD_NUMBERS = ("abc", "-3", "nan", "NaN", "inf", "-inf", "1e400", "", " ", "½", "9" * 5000, "-1e9", "None", "\x00", "1,5", "0x10")
SIZED = ("render", "certify", "sensitivity", "chart", "plan", "attribute", "bench")
NAMED = {"compare": "--renderers", "stability": "--family", "chart": "--growth", "render": "--with", "attribute": "--with",
         "export": "--object", "bench": "--only"}
FOLDERS = {"compare": "--results", "transport": "-o", "stability": "-o", "chart": "-o", "plan": "--results", "report": "--results",
           "bench": "-o"}
FILES = {"render": "-o", "sensitivity": "-o", "plan": "-o", "export": "-o"}
SETTINGS = ("resolution=abc", "resolution=NaN", "resolution=1e9", "resolution=-5", "resolution=", "resolution", "=3", "colour=red",
            "resolution=" + "[" * 5000, "shapes=none", "error=nan", "error=-1", "refined=maybe", "resolution=3.5", "repeat=2",
            "\x00=1", "resolution=null", "share=2", "error=inf")


def options(chance: random.Random) -> Input:
    """A command with a scene that is good, and something that is wrong."""
    command = chance.choice([name for name in COMMANDS if name != "doctor"])
    files: dict[str, bytes | None] = {"good.json": json.dumps(GOOD).encode()}
    arguments = [command]
    scene, output = "{dir}/good.json", "{dir}/out.ply" if command == "export" else "{dir}/out.npz"
    wrong = chance.choice([name for name, there in (
        ("number", command in NUMERIC), ("size", command in SIZED), ("name", command in NAMED), ("folder", command in FOLDERS),
        ("file", command in FILES), ("scene", command not in ("report", "stability", "transport", "bench")), ("option", True),
        ("setting", command == "render"), ("contradiction", command in ("render", "attribute"))) if there])
    extra: list[str] = []
    match wrong:
        case "number":
            extra = [f"{chance.choice(NUMERIC[command])}={chance.choice(BAD_NUMBERS)}"]
        case "size":
            extra = [f"--size={chance.choice(SIZES)}"]
        case "name":
            extra = [f"{NAMED[command]}={chance.choice(WORDS)}" + chance.choice(("", "", "?"))]
            extra = [extra[0] + "?" if extra[0].endswith(("=", "--object=0")) else extra[0]]  # objects have numbers, too
        case "folder":
            files["blocked"] = b""
            extra = [f"{FOLDERS[command]}={chance.choice(('{dir}/blocked', '{dir}/blocked/inside', '/proc/1/x', '/dev/null'))}"]
        case "file":
            output = chance.choice(("{dir}", "{dir}/none/out.npz", "{dir}/out.gif", "/proc/out.npz", "/dev/null", "{dir}/out", "",
                                    "{dir}/" + "n" * 400 + ".npz", "\x00.npz"))
            extra = [] if command in ("render", "export") else [f"{FILES[command]}={output}"]
        case "scene":
            files |= {"pipe.json": None, "broken.json": b"{", "empty.json": b""}
            scene = chance.choice(("{dir}", "{dir}/pipe.json", "/dev/zero", "/dev/null", "{dir}/missing.json", "no-such-scene",
                                   "{dir}/broken.json", "{dir}/empty.json", "", "a\x00b.json", "/proc/self/mem", "\udcff.json",
                                   "n" * 5000 + ".json", "./", "/etc/shadow/x.json", "💥"))
        case "option":
            extra = [chance.choice(("--no-such-option", "--resolution", "-q", "--size", "--sizes=3x3", "---", "--=3", "-o"))]
        case "setting":
            extra = ["--with", chance.choice(("mitsuba-mesh", "embree", "mitsuba-native")), "--set", chance.choice(SETTINGS)] \
                if chance.random() < 0.8 else ["--set", "resolution=16"]
        case "contradiction":
            extra = (["--with", "embree", *chance.choice((["--method", "paper"], ["--precision", "32"], ["--device", "llvm"],
                                                          ["--threads", "1"], ["--memory", "1"]))]
                     if command == "render" else ["--wrong-on-purpose"])
    if command in ("scenes", "render", "certify", "sensitivity", "compare", "chart", "plan", "attribute", "export"):
        arguments += [scene] if not scene.startswith("-") else ["--", scene]
    if command in ("render", "export"):
        arguments += ["-o", output]
    if command == "attribute" and wrong != "name" and wrong != "contradiction":
        arguments += ["--with", "paper"]
    return Input(0, "", arguments + extra, files, must_fail=True)
