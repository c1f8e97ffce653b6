"""What the checker and a port say to each other, over the port's stdin and stdout (docs/ports/protocol.md).

A message is one line of JSON and as many bytes as its "bytes" says: a request carries a scene as text or JSON, an answer
raw little-endian arrays. Whatever a port answers is checked before anything is made of it: the length before it is read,
the arrays before they are looked at.
"""

from __future__ import annotations

import json
import math
from dataclasses import dataclass
from typing import Annotated, Literal

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, ValidationError

from raytruth.converters.plain import KINDS, plain
from raytruth.reference_tracer.scene.load import one_line, printable
from raytruth.reference_tracer.scene.model import Scene

PROTOCOL = 1
LONGEST_HEADER = 1 << 16  # bytes
LONGEST_MESSAGE = 300  # characters shown of what a port says
TYPES = {"float64": "<f8", "float32": "<f4", "int32": "<i4"}
# what may be answered: kinds of numbers, and the shape at a pixel or ray
ARRAYS = {"color": ("f", (3,)), "index": ("i", ()), "t": ("f", ()), "normal": ("f", (3,))}
Level = Literal["algorithm", "model"]
LEVELS: tuple[Level, ...] = ("algorithm", "model")
METHODS = {"algorithm": "paper", "model": "exact"}  # the reference's, by the truth that they are
EFFECTS = ("shadow", "reflection", "refraction", "multisampling", "rotation")
SWITCHES = ("E1", "F1", "F2", "F3", "F4", "F5")


class MalformedError(ValueError):
    """An answer that is none; the text says why, in one printable line."""


def _some(*words):
    return Annotated[tuple[Literal[words], ...], Field(max_length=len(words))]


class Declaration(BaseModel):
    """What a port says of itself when it is greeted."""

    model_config = ConfigDict(frozen=True, strict=False, allow_inf_nan=False)
    protocol: Literal[1]
    name: Annotated[str, Field(min_length=1, max_length=100)]
    version: Annotated[str, Field(max_length=100)] = ""
    scenes: Literal["text", "json"] = "text"
    levels: Annotated[tuple[Level, ...], Field(min_length=1, max_length=2)]
    precision: Literal[64, 32]
    surfaces: _some(*KINDS) = KINDS
    effects: _some(*EFFECTS) = EFFECTS
    switches: _some(*SWITCHES) = ()


@dataclass(frozen=True)
class Question:
    """A picture of `scene`, or, where there are `rays` (n, 6), what each of them meets: origin and unit direction."""

    scene: Scene
    level: Level
    rays: np.ndarray | None = None

    @property
    def shape(self) -> tuple[int, ...]:
        camera = self.scene.camera
        return (camera.height, camera.width) if self.rays is None else (len(self.rays),)

    @property
    def op(self) -> str:
        return "render" if self.rays is None else "trace"

    @property
    def most_bytes(self) -> int:
        """Of a faithful answer: every array in double precision."""
        return math.prod(self.shape) * sum(8 * math.prod(shape) for _, shape in ARRAYS.values())

    def payload(self, form: str) -> bytes:
        """The scene as `form` says, with the rays."""
        rays = [] if self.rays is None else self.rays.tolist()
        if form == "text":
            lines = [" ".join(["ray", *map(repr, ray)]) for ray in rays]
            return (plain(self.scene) + "".join(line + "\n" for line in lines)).encode("ascii")
        document = self.scene.model_dump(mode="json", exclude={"schema_"}, exclude_none=True)
        return json.dumps({**document, "rays": rays} if rays else document).encode()

    def request(self, seq: int, form: str) -> bytes:
        payload = self.payload(form)
        # the order of the keys and the blanks are part of the protocol: a port may scan them
        return header(seq, self.op, self.level, len(payload)) + payload


def header(seq: int, op: str, level: str, size: int) -> bytes:
    return f'{{"seq": {seq}, "op": "{op}", "level": "{level}", "bytes": {size}, "protocol": {PROTOCOL}}}\n'.encode()


HELLO = header(0, "hello", "none", 0)


@dataclass
class Reply:
    """What a port answered: arrays by name, fp64 and int32; or why it does not, in its own words."""

    arrays: dict[str, np.ndarray]
    unsupported: str | None = None


class Incoming:
    """Tells, while an answer arrives, whether it is whole. Raises MalformedError as soon as it cannot be one."""

    def __init__(self, most_bytes: int):
        self.most_bytes, self.header, self.start, self.end = most_bytes, None, 0, 0

    def __call__(self, said: bytes) -> bool:
        if self.header is None:
            line, newline, _ = said.partition(b"\n")
            if len(line) > LONGEST_HEADER:
                raise MalformedError(f"the first line is longer than {LONGEST_HEADER >> 10} KiB: {shown(line)}")
            if not newline:
                return False
            self.header = _object(line)
            size = self.header.get("bytes", 0)
            if not isinstance(size, int) or isinstance(size, bool) or size < 0:
                raise MalformedError(f'"bytes" must be a whole number; found {shown(repr(size))}')
            if size > self.most_bytes:
                raise MalformedError(f"announces {size:,} bytes; an answer to this has at most {self.most_bytes:,}")
            self.start, self.end = len(line) + 1, len(line) + 1 + size
        return len(said) >= self.end


def _object(line: bytes) -> dict:
    try:
        found = json.loads(line)
    except (ValueError, RecursionError):
        raise MalformedError(f"the first line is not JSON: {shown(line)}") from None
    if not isinstance(found, dict):
        raise MalformedError(f"the first line is not a JSON object: {shown(line)}")
    return found


def shown(said: bytes | str) -> str:
    """What a port said, fit to be shown."""
    return printable(said[:LONGEST_MESSAGE].decode(errors="replace") if isinstance(said, bytes) else said, 80)


def declaration(incoming: Incoming) -> Declaration:
    """Raises MalformedError."""
    known = set(Declaration.model_fields)
    try:
        return Declaration.model_validate({k: v for k, v in incoming.header.items() if k in known})
    except ValidationError as error:
        raise MalformedError(f"the answer to hello: {printable(one_line(error), LONGEST_MESSAGE)}") from None


def reply(question: Question, seq: int, incoming: Incoming, said: bytes) -> Reply:
    """The arrays of an answer. Raises MalformedError."""
    head = incoming.header
    if head.get("seq") != seq or isinstance(head.get("seq"), bool):
        raise MalformedError(f'"seq" is {shown(repr(head.get("seq")))}, the request\'s was {seq}')
    if (state := head.get("state")) == "unsupported":
        return Reply({}, shown(str(head.get("message", ""))) or "no reason given")
    if state != "ok":
        raise MalformedError(f'"state" must be "ok" or "unsupported"; found {shown(repr(state))}')
    if len(said) > incoming.end:
        raise MalformedError(f"{len(said) - incoming.end} bytes more than announced")
    listed = head.get("arrays")
    if not isinstance(listed, list) or not 0 < len(listed) <= len(ARRAYS):
        raise MalformedError(f'"arrays" must list 1 to {len(ARRAYS)} arrays')
    arrays, start = {}, incoming.start
    for entry in listed:
        name, dtype, shape = _described(entry, question)
        if name in arrays:
            raise MalformedError(f"the array {name} comes twice")
        size = math.prod(shape) * np.dtype(dtype).itemsize
        if start + size > incoming.end:
            raise MalformedError(f'{name} would end after the "bytes" announced')
        array = np.frombuffer(said, dtype, math.prod(shape), start).reshape(shape)
        arrays[name] = array.astype(np.int32 if array.dtype.kind == "i" else np.float64)
        start += size
    if start != incoming.end:
        raise MalformedError(f"{incoming.end - start} bytes belong to no array")
    if "color" not in arrays:
        raise MalformedError("there is no array color")
    if "index" in arrays and not -1 <= arrays["index"].min() <= arrays["index"].max() < len(question.scene.objects):
        raise MalformedError(f"objects {arrays['index'].min()} to {arrays['index'].max()} of a scene with "
                             f"{len(question.scene.objects)}, numbered from 0; -1 is none")
    return Reply(arrays)


def _described(entry, question: Question) -> tuple[str, str, tuple[int, ...]]:
    if not isinstance(entry, dict) or entry.get("name") not in ARRAYS:
        raise MalformedError(f"an array must be one of {', '.join(ARRAYS)}; found {shown(repr(entry))}")
    name = entry["name"]
    kinds, own = ARRAYS[name]
    dtype = TYPES.get(entry["dtype"]) if isinstance(entry.get("dtype"), str) else None
    if dtype is None or np.dtype(dtype).kind not in kinds:
        right = [word for word, code in TYPES.items() if np.dtype(code).kind in kinds]
        raise MalformedError(f"{name}: dtype must be {' or '.join(right)}; found {shown(repr(entry.get('dtype')))}")
    if entry.get("shape") != [*question.shape, *own]:
        raise MalformedError(f"{name}: shape must be {[*question.shape, *own]}; found {shown(repr(entry.get('shape')))}")
    return name, dtype, (*question.shape, *own)
