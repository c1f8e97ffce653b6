"""What a check leaves behind: its document, and the same as JUnit XML, as a badge, and as the list of known failures."""

from __future__ import annotations

import json
from collections import Counter
from pathlib import Path
from typing import Literal
from xml.etree import ElementTree

from raytruth.reference_tracer.errors import InputError

from ..document import Record
from ..execution.machine import Machine
from ..execution.store import atomically
from .protocol import Declaration

Verdict = Literal["pass", "acceptable", "fail", "non-finite", "malformed", "timeout", "crashed", "skipped"]
GOOD, BAD = ("pass", "acceptable"), ("fail", "non-finite", "malformed", "timeout", "crashed")
LARGEST = 1 << 20  # bytes of a list of known failures
FORMAT = "raytruth known failures 1"


class Part(Record):
    """A pixel, or a ray by its number and the id of its test vector."""

    row: int | None = None
    col: int | None = None
    ray: int | None = None
    id: str | None = None

    @property
    def text(self) -> str:
        return f"pixel ({self.row}, {self.col})" if self.row is not None else f"ray {self.id or self.ray}"


class Cause(Record):
    """A mistake that explains wrong answers: `share` of what differs would be unexplained without it."""

    id: str
    sentence: str
    share: float


class CaseResult(Record):
    """One case. `expected`, `got` and `bound` are those of the worst pixel of the first `plane` that is wrong."""

    id: str
    section: str
    verdict: Verdict
    message: str
    stage: str | None = None
    plane: str | None = None
    where: Part | None = None
    expected: list[float] | None = None
    got: list[float] | None = None
    bound: float | None = None
    pixels: int = 0
    differing: int = 0
    acceptable: int = 0
    undecided: int = 0
    seconds: float = 0.0
    known: bool = False  # a failure that was listed beforehand


class Check(Record):
    """A whole run."""

    version: Literal[1] = 1
    created: str
    seconds: float
    machine: Machine
    command: list[str]
    port: Declaration | None
    message: str = ""  # why nothing was asked
    results: list[CaseResult]
    causes: list[Cause] = []  # together, what most hangs on first

    @property
    def counts(self) -> Counter:
        return Counter(result.verdict for result in self.results)

    @property
    def mended(self) -> list[str]:
        """Cases listed as failing that pass."""
        return [r.id for r in self.results if r.known and r.verdict in GOOD]

    @property
    def broken(self) -> list[CaseResult]:
        """Failures that were not listed."""
        return [r for r in self.results if r.verdict in BAD and not r.known]

    @property
    def holds(self) -> bool:
        """Whether nothing failed that was not listed, nothing passes that was, and something was judged at all."""
        judged = any(r.verdict != "skipped" for r in self.results)
        return judged and not self.broken and not self.mended and not self.message

    @property
    def sentence(self) -> str:
        """Of all cases, those skipped among them."""
        counts = self.counts
        words = [f"{counts[verdict]} {verdict}" for verdict in (*GOOD, *BAD, "skipped") if counts[verdict]]
        return f"{sum(counts[v] for v in GOOD)} of {len(self.results)} cases hold ({', '.join(words)})"


def junit(check: Check) -> bytes:
    """JUnit XML, as continuous integration reads it."""
    count = lambda *verdicts: str(sum(check.counts[v] for v in verdicts))
    suite = ElementTree.Element("testsuite", name=_clean(f"raytruth check-port {check.port.name if check.port else ''}"),
                                tests=str(len(check.results)), failures=count("fail", "non-finite"),
                                errors=count("malformed", "timeout", "crashed"), skipped=count("skipped"),
                                time=f"{check.seconds:.1f}")
    for result in check.results:
        level, _, name = result.id.partition(":")
        case = ElementTree.SubElement(suite, "testcase", classname=level, name=name, time=f"{result.seconds:.3f}")
        kind = ("skipped" if result.verdict == "skipped" or (result.known and result.verdict in BAD) else
                "failure" if result.verdict in ("fail", "non-finite") or (result.known and result.verdict in GOOD) else
                "error" if result.verdict in BAD else None)
        if kind:
            ElementTree.SubElement(case, kind, message=_clean(result.message or "listed as failing, but passes"))
    return ElementTree.tostring(suite, encoding="utf-8", xml_declaration=True)


def _clean(text: str) -> str:
    """Without what XML 1.0 cannot hold."""
    return "".join(c if c.isprintable() else "?" for c in text)


def badge(check: Check) -> dict:
    """The endpoint form of shields.io."""
    counts = check.counts
    good, color = sum(counts[v] for v in GOOD), "brightgreen"
    if not check.holds:
        color = "red"
    elif counts["skipped"]:
        color = "yellowgreen"
    return {"schemaVersion": 1, "label": "raytruth", "message": f"{good}/{len(check.results)}", "color": color}


def write_known(check: Check, path: Path) -> None:
    """The list of the cases that failed, for `read_known`."""
    with atomically(path) as part:
        part.write_text(json.dumps({"format": FORMAT, "failing": sorted(r.id for r in check.results if r.verdict in BAD)},
                                   indent=1) + "\n", encoding="utf-8")


def read_known(path: Path) -> frozenset[str]:
    """Raises InputError."""
    try:
        with path.open("rb") as file:
            data = file.read(LARGEST + 1)
        found = json.loads(data if len(data) <= LARGEST else b"")
        if found["format"] != FORMAT or not all(isinstance(id, str) for id in found["failing"]):
            raise ValueError
        return frozenset(found["failing"])
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror}); --write-known-failures makes it") from None
    except (ValueError, KeyError, TypeError, RecursionError):
        raise InputError(f"{path}: is no list of known failures; make it again with --write-known-failures") from None
