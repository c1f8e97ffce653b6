"""The document of the stability suite, `stability.json`: what a report needs to draw failure maps and laws.

Structure: `families` hold one `Series` for every method and precision, a series one `Point` for every value of the
difficulty p, a point how many rays ended as which kind. A failure map of one family is its series as rows and
`values` as columns, coloured by `Point.worst`. `kinds` explains the kinds; `findings` are what must not happen.
"""

from __future__ import annotations

from pathlib import Path
from typing import Literal

from pydantic import Field

from .. import document
from ..document import Record
from ..results import Machine, State

FILE = "stability.json"
FOLDER = "stability"
COMMAND = "raytruth stability"

MOST_EVALUATIONS = 10_000  # of f for one ray; the literal method spends 600 on a range of 30 with steps of 0.05

KINDS = {
    "correct": "the exact answer",
    "missed": "the ray crosses the surface, and nothing was reported",
    "false": "a crossing was reported where there is none, or an answer was given where f is undefined",
    "wrong root": "another root on the ray was reported in place of the first crossing",
    "diverged": "a point was reported that is no root at all",
    "non-finite": "the distance reported is infinite or not a number",
    "wrong value": "a colour or a direction is off by more than the stated accuracy",
    "undecided": "the method says itself that it does not know",
    "too slow": f"right, but with more than {MOST_EVALUATIONS} evaluations of f for one ray"}
NAMES = tuple(KINDS)
CODE = {name: code for code, name in enumerate(NAMES)}
WRONG = ("missed", "false", "wrong root", "diverged", "non-finite", "wrong value")  # and not flagged

Kind = Literal[*NAMES]


class MethodRecord(Record):
    """A method under test."""

    name: str = Field(description="as in Series.method and LawRecord.method")
    title: str
    claims: bool = Field(description="whether it claims that answers it does not flag are right (double precision)")
    wrong_variant: str = Field("", description="if not empty: shown for comparison only, and why it must fail")


class Point(Record):
    """What a method did at one value of p."""

    counts: dict[Kind, int] = Field(description="rays by kind; kinds that did not occur are left out; empty where the "
                                                "method does not apply")
    worst_error: float | None = Field(None, description="largest error of the correct answers: of t, or of colour or "
                                                        "direction in families of the whole model")
    evaluations: float | None = Field(None, description="mean number of evaluations of f a ray, where it is counted")

    @property
    def rays(self) -> int:
        return sum(self.counts.values())

    def rate(self, *kinds: str) -> float:
        """The share of rays that ended as one of `kinds`."""
        return sum(self.counts.get(kind, 0) for kind in kinds) / max(self.rays, 1)

    @property
    def worst(self) -> str:
        """The kind to colour the point by: the most frequent one that is not "correct", if there is any."""
        others = {kind: n for kind, n in self.counts.items() if kind != "correct"}
        return max(others, key=others.get) if others else "correct"


class Series(Record):
    """One method, in one precision, over all values of p."""

    method: str
    precision: Literal[64, 32]
    points: list[Point] = Field(description="one for each of FamilyRecord.values (64) or values_single (32), in order")


class LawPoint(Record):
    """Measured rate against the law at one value of p."""

    value: float
    expected: float
    low: float = Field(description="the binomial band of this sample about `expected`: lower end")
    high: float = Field(description="its upper end")
    measured: float
    within: bool


class LawRecord(Record):
    """How often a method must fail by theory, and how often it did (double precision)."""

    method: str
    sentence: str = Field(description="the law in words, with its formula")
    kinds: list[Kind] = Field(description="what counts: the rate is the share of rays that ended as one of these")
    curve: list[tuple[float, float]] = Field(description="(p, rate) along a logarithmic axis, to be drawn as a line")
    points: list[LawPoint] = Field(description="the values of p at which the law speaks")
    holds: bool


class FamilyRecord(Record):
    """A family of cases with one difficulty."""

    id: str
    title: str
    parameter: str = Field(description="what the difficulty p is")
    values: list[float] = Field(description="of p, from easy to hard")
    values_single: list[float] = Field(description="of p in single precision; empty where that is not run")
    labels: list[str] = Field(description="names of the values, if numbers alone say little; else empty")
    when: str = Field(description="one sentence: when do methods fail here")
    why: str
    instead: str = Field(description="what to use instead")
    series: list[Series]
    laws: list[LawRecord]


class Finding(Record):
    """A method that claims exactness gave wrong answers without saying so, or a law is broken."""

    what: Literal["wrong and not flagged", "law broken", "not measured"]
    family: str
    method: str
    values: list[float] = Field(description="of p, where it happened")
    rates: list[float] = Field(description="the share of rays at each of `values`: of wrong answers, or as measured")
    kinds: list[Kind] = Field(description="what went wrong, the most frequent first; of a law: what it counts")
    sentence: str
    example: dict | None = Field(None, description="a wrong ray: origin o, direction d, side, limit, the numbers f "
                                                   "takes, the exact distance and the one reported")


class Examined(Record):
    """One family and what must not happen in it; `record` is there if `state` is "ok"."""

    state: State = "ok"
    message: str = ""
    record: FamilyRecord | None = None
    findings: list[Finding] = []


class Stability(Record):
    """The whole document."""

    version: Literal[1] = 1
    created: str
    seconds: float
    machine: Machine
    seed: int
    rays: int = Field(description="at every value of p")
    confidence: float = Field(description="of the band of one law at one value")
    kinds: dict[Kind, str] = Field(description="every kind in one sentence")
    methods: list[MethodRecord]
    families: list[FamilyRecord]
    findings: list[Finding]

    def family(self, id: str) -> FamilyRecord:
        return next(f for f in self.families if f.id == id)


def keep(stability: Stability, folder: Path, fresh: bool = False) -> Stability:
    """Writes the document into `folder`, with the other families that are there unless `fresh` or of other rays."""
    earlier = None if fresh else document.found(folder / FILE, Stability, COMMAND)
    found = document.joined(earlier, stability, {"families": lambda f: f.id, "findings": lambda f: f.family},
                            {f.id for f in stability.families} | {f.family for f in stability.findings}, ("rays", "seed"))
    return document.keep(document.joined(earlier, found, {"methods": lambda m: m.name}), folder / FILE, COMMAND)


def read(folder: str | Path) -> Stability:
    """The document in `folder`. Raises InputError in one line."""
    return document.read(Path(folder) / FILE, Stability, COMMAND)
