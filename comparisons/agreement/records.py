"""The matrix document: one versioned JSON file beside results.json, made of the same runs."""

from __future__ import annotations

from pathlib import Path
from typing import Literal

from pydantic import Field

from .. import document
from ..document import Record
from ..results import State

VERSION = 1
FILE, COMMAND = "matrix.json", "raytruth compare"


class Member(Record):
    """A renderer of the matrix."""

    name: str
    title: str
    implementation: str = Field(description="renderers of one implementation share their shading, and one vote")


class Place(Record):
    """A scene of the matrix."""

    name: str
    title: str
    pixels: int
    effect: bool = Field(description="whether the scene shows one effect alone")


class Pair(Record):
    """Two renderers on one scene."""

    scene: str
    first: str
    second: str
    agrees: bool
    expected: bool = Field(False, description="whether a limit is exceeded by what the literal method misses")
    tolerance: str = Field(description="the limits they were held to, by name")
    instead: str = Field("", description="what of the scene is otherwise in both pictures, because one cannot express it")
    broken: str = Field("", description="the first limit that is exceeded, with its numbers")
    color_p99: float | None = Field(description="99 % of the pixels differ by less")
    color_max: float | None
    inner_max: float | None = Field(description="the same away from silhouettes of what is seen first")
    failing: int | None = Field(description="pixels off by more than one step of an 8-bit picture")
    mismatches: int | None = Field(description="pixels where another object, or none, was hit")
    depth_p99: float | None = Field(description="99 % of interior pixels have a smaller relative error of depth")


class Absent(Record):
    """A renderer without a picture of a scene, and why."""

    scene: str
    renderer: str
    state: State
    reason: str


class Dissent(Record):
    """A scene on which not all agree: the renderers that all the others contradict."""

    scene: str
    renderers: list[str] = Field(description="those who are wrong together; of a split: one of them is")
    against: list[str] = Field(description="those they disagree with")
    stages: list[str] = Field([], description="what their pictures hang on, and no other's")
    split: bool = Field(False, description="whether nobody can say who is wrong")
    expected: bool = Field(description="whether it is what the literal method misses, as its oracle does")
    sentence: str


class Tightness(Record):
    """One limit of a tolerance: what it lets pass, and what it stops."""

    tolerance: str
    gate: str
    limit: float = Field(description="in pixels of the scene where there is a share")
    unit: str
    scene: str = Field(description="where the renderer comes closest to the limit")
    share: float = Field(description="how much of the limit it takes up there")
    worse: str = Field(description="the next worse setting, in words")
    worse_scene: str = Field(description="where that one comes closest to the limit, or exceeds it most")
    worse_share: float
    verdict: Literal["tight", "loose"] = Field(description="tight: the worse setting exceeds the limit somewhere")
    command: str


class Matrix(Record):
    """Everything the matrix page is made of."""

    version: Literal[1] = VERSION
    members: list[Member]
    places: list[Place]
    pairs: list[Pair]
    absent: list[Absent]
    dissent: list[Dissent]
    tightness: list[Tightness] = []
    command: str


def joined(earlier: Matrix | None, matrix: Matrix) -> Matrix:
    """`matrix` with what an earlier one says of other scenes."""
    scenes = {place.name for place in matrix.places}
    about = {"places": lambda p: p.name, **dict.fromkeys(("pairs", "absent", "dissent"), lambda row: row.scene)}
    found = document.joined(earlier, matrix, about, scenes)
    return document.joined(earlier, found, {"members": lambda m: m.name, "tightness": lambda t: (t.tolerance, t.gate)})


def write(matrix: Matrix, folder: Path) -> Path:
    document.keep(matrix, folder / FILE, COMMAND)
    return folder / FILE


def read(folder: Path) -> Matrix:
    """The matrix in `folder`. Raises InputError in one line."""
    return document.read(folder / FILE, Matrix, COMMAND)
