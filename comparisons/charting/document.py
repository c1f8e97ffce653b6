"""The document of the charts, `chart.json`: every point with its accuracy, its cost, or why it has none."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from statistics import mean
from typing import Literal

from pydantic import Field

from .. import document
from ..bench.document import Clock, Spread
from ..bench.timing import QUIET
from ..document import Record
from ..results import BROKEN, Machine, State

FILE = "chart.json"
FOLDER = "chart"
COMMAND = "raytruth chart"


class Accuracy(Record):
    """A picture against the proven one, over the pixels that rounding does not decide."""

    pixels: int = Field(description="compared")
    wrong: int = Field(description="of these: another object, another root, or a colour that is not finite")
    visible: int = Field(description="of these: a colour off by more than one step of an 8-bit picture, for any reason")
    depth_p99: float | None = Field(description="of |t - truth| / max(1, truth), over pixels that are not wrong")
    depth_max: float | None
    color_p99: float | None = Field(description="of a pixel's largest difference in a channel, over all compared")
    color_max: float | None
    undecided: int = Field(description="pixels of the whole picture that the method itself does not vouch for")


class Times(Record):
    """Seconds of a warm run, over interleaved turns; cpu is that of all threads."""

    wall: Spread
    cpu: Spread


class Point(Record):
    """One method at one value of its parameter."""

    label: str = Field(description="the parameter with its value, as text")
    value: float | None = Field(description="None where the method has no parameter")
    settings: dict[str, float | int | str | bool]
    state: State
    message: str = Field("", description="what went wrong, in one line")
    accuracy: Accuracy | None = None
    picture: Times | None = Field(None, description="of a whole picture, without compiling or building")
    hits: Times | None = Field(None, description="of the camera rays' first hits alone, where they can be had apart")
    build: Spread | None = Field(None, description="wall seconds of converting the scene: meshes, grids, structures")
    compiling: float | None = Field(None, description="wall seconds by which the first run took longer than a warm one")
    evaluations: float | None = Field(None, description="of f, a camera ray, summed over objects")
    peak_mib: float | None = Field(None, description="memory of the measuring process, or of the program it ran")
    turns: int = 0
    others: float = Field(0.0, description="cores that other programs kept busy while the times were taken")

    @property
    def is_fault(self) -> bool:
        return self.state in BROKEN


class Series(Record):
    """One sweep."""

    id: str
    method: str = Field(description="sweeps of one method share this")
    title: str
    kind: Literal["first hits", "converter", "control"]
    parameter: str = Field(description="what is swept, in words; empty for a single point")
    points: list[Point]


class Uncertainty(Record):
    """How far the truth itself may be off: what moving every ray by a few units of rounding changes."""

    depth_p99: float
    depth_max: float
    color_p99: float
    color_max: float


class Subject(Record):
    """A scene or a single surface with everything that was charted on it."""

    id: str
    title: str
    kind: Literal["scene", "surface"]
    width: int
    height: int
    objects: int
    pixels: int = Field(description="compared: neither undecided by the proof nor at an edge that rounding moves")
    undecided: int = Field(description="pixels that the proof leaves undecided")
    uncertainty: Uncertainty | None = Field(description="None where there is no truth")
    state: State = "ok"
    message: str = Field("", description="why there is no truth")
    series: list[Series]
    findings: list[str] = Field(description="what the charts say, a sentence each")
    command: str


class GrowthPoint(Record):
    x: float
    state: State
    message: str = ""
    picture: Times | None = None
    rays: int | None = None
    peak_mib: float | None = None
    second: float | None = Field(None, description="what Growth.second_label says")


class GrowthLine(Record):
    label: str
    points: list[GrowthPoint]


class Growth(Record):
    """How time, and one thing besides, grow with one parameter of the picture."""

    id: str
    title: str
    x_label: str
    second_label: str
    lines: list[GrowthLine]
    finding: str = Field(description="what was measured, in one sentence")
    others: float = Field(description="cores that other programs kept busy meanwhile")
    command: str


class Chart(Record):
    """The whole document."""

    version: Literal[1] = 1
    created: str
    seconds: float
    machine: Machine
    threads: int
    turns: int
    truth: str = Field(description="the method that the others are held against, in words")
    subjects: list[Subject]
    growths: list[Growth]

    @property
    def clock(self) -> Clock:
        """Which times are charted: on a machine that had other work to do, those of the processor."""
        points = [p.others for s in self.subjects for series in s.series for p in series.points if p.turns]
        return clock([*points, *(growth.others for growth in self.growths)])

    @property
    def faults(self) -> list[tuple[str, str, str]]:
        """(subject, what, message) of everything that crashed, hung or answered nonsense."""
        found = [(s.id, "truth", s.message) for s in self.subjects if s.state in BROKEN]
        found += [(s.id, f"{series.title}, {p.label}" if p.label else series.title, f"{p.state}: {p.message}")
                  for s in self.subjects for series in s.series for p in series.points if p.is_fault]
        return found + [(g.id, f"{line.label} at {p.x:g}", f"{p.state}: {p.message}")
                        for g in self.growths for line in g.lines for p in line.points if p.state in BROKEN]


def clock(others: list[float]) -> Clock:
    """Which times decide where `others` cores were busy elsewhere, measurement by measurement."""
    return "wall" if not others or mean(others) < QUIET else "cpu"


def keep(chart: Chart, folder: Path, fresh: bool = False) -> Chart:
    """Writes the document into `folder`, with the other subjects and studies that are there unless `fresh`."""
    earlier = None if fresh else document.found(folder / FILE, Chart, COMMAND)
    rows = {"subjects": lambda s: s.id, "growths": lambda g: g.id}
    return document.keep(document.joined(earlier, chart, rows, same=("turns", "threads")), folder / FILE, COMMAND)


def read(folder: str | Path) -> Chart:
    """The document in `folder`. Raises InputError in one line."""
    return document.read(Path(folder) / FILE, Chart, COMMAND)


def frontier(points: Iterable[tuple[float, float]]) -> list[tuple[float, float]]:
    """Of points (cost, error) those that no other one equals or beats in both (Pareto), by rising cost and falling error."""
    best: list[tuple[float, float]] = []
    for cost, error in sorted(set(points)):
        if not best or error < best[-1][1]:
            best.append((cost, error))
    return best
