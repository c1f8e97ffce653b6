"""The effects of the document's model, one by one: who checked each, how closely they agree, which faults are noticed."""

from __future__ import annotations

from dataclasses import dataclass

from raytruth.comparisons.attribution.document import FILE, Judgement, WrongOnPurpose, read
from raytruth.comparisons.results import SceneRecord
from raytruth.comparisons.transport import document as transport
from raytruth.comparisons.transport.document import CaseRecord

from ..cases import Case
from ..text.words import VERDICTS, Verdict, slug
from .page import Page, Report, Summary

__all__ = ["FILE", "pages", "read"]

PREFIX = "effect-"  # of the scenes that show one effect each


@dataclass(frozen=True)
class Checked:
    """One effect: its name, what is checked, and where the document has it."""

    name: str
    what: str
    section: str

    @property
    def id(self) -> str:
        return slug(self.name.replace(" ", "-"))


CHECKED = (
    Checked("shading", "the light that falls on a point, its angle and its colours", "4.3.1"),
    Checked("shadow", "what reaches a point past solid and clear objects", "4.3.1"),
    Checked("reflection", "where a mirror’s ray goes, and what it brings back", "4.3.2"),
    Checked("refraction", "where a ray goes on entering and leaving clear objects", "4.3.3.2"),
    Checked("total reflection", "the rays that cannot leave a clear object", "4.3.3.1"),
    Checked("mixing", "the sum of a point’s own colour and those of its two rays", "4.3.4"),
    Checked("multisampling", "the mean over a pixel’s samples", "5"),
)


@dataclass(frozen=True)
class Fault:
    """A fault made on purpose, with who found it."""

    record: WrongOnPurpose

    @property
    def anchor(self) -> str:
        return slug(self.record.id)

    @property
    def verdict(self) -> Verdict:
        if all(j.state != "ok" for j in self.record.judgements):
            return VERDICTS["not compared"]
        return VERDICTS["agrees" if self.record.holds else "differs"]

    @property
    def is_control(self) -> bool:
        """Whether it is no fault at all, but the tracer as it is."""
        return self.record.expected is None


@dataclass(frozen=True)
class EffectEvidence:
    """Everything a report knows about one effect."""

    checked: Checked
    scene: SceneRecord | None
    cases: list[Case]
    transport: list[CaseRecord]  # those that theory says are equal
    faults: list[Fault]
    control: Fault | None

    @property
    def page(self) -> str:
        return f"evidence/{self.checked.id}.html"

    @property
    def independent(self) -> list[Case]:
        """The comparisons that could be made with renderers that are not ours, the closest first."""
        found = [c for c in self.cases if not c.is_literal and c.comparison.metrics.get("color p99") is not None]
        return sorted(found, key=lambda c: c.comparison.metrics["color p99"])

    @property
    def verdict(self) -> Verdict:
        """The worst of all that was found."""
        found = [c.comparison.verdict for c in self.cases if c.comparison.verdict != "expected"]
        found += ["agrees" if case.holds else "differs" for case in self.transport if case.state == "ok"]
        judged = [f.verdict for f in (*self.faults, *filter(None, [self.control]))]
        found += ["differs" for verdict in judged if verdict is VERDICTS["differs"]]
        if "differs" in found:
            return VERDICTS["differs"]
        return VERDICTS["agrees" if "agrees" in found else "not compared"]

    @property
    def noticed(self) -> int:
        return sum(fault.record.holds for fault in self.faults)


def pages(report: Report) -> list[Page]:
    effects = evidence(report)
    if not effects:
        return []
    faults = [fault for e in effects for fault in e.faults]
    noticed = sum(fault.record.holds for fault in faults)
    found = f"{sum(e.verdict.style == 'agrees' for e in effects)} of {len(effects)} agree"
    found += f"; {noticed} of {len(faults)} faults made on purpose are found and named." if faults else "."
    overview = Page("evidence.html", "evidence.html.j2", {
        "effects": effects, "judges": judges(effects), "judgement": judgement, "faults": faults, "noticed": noticed,
    }, nav="Effects, one by one", summary=Summary(
        "Effects, one by one", "Shading, shadow, reflection, refraction, total reflection, mixing and multisampling, "
        "each on a scene of its own: what was checked, by whom, and how closely they agree.", found, "The evidence"))
    around = zip([None, *effects[:-1]], effects, [*effects[1:], None])
    return [overview, *(Page(e.page, "effect.html.j2", {"effect": e, "before": before, "after": after})
                        for before, e, after in around)]


def evidence(report: Report) -> list[EffectEvidence]:
    """Of every effect that anything is known about, in the document's order."""
    scenes = {scene.name: scene for scene in report.results.scenes}
    table = report.documents.get(FILE)
    own = report.documents.get(transport.FILE)
    found = []
    for checked in CHECKED:
        name = PREFIX + checked.id
        scene = scenes.get(name)
        rows = [Fault(row) for row in (table.rows if table else []) if row.effect == name]
        cases = [c for c in (own.cases if own else []) if c.effect == checked.name and c.kind == "equal"]
        found.append(EffectEvidence(
            checked, scene, report.of_scene(scene) if scene else [], cases,
            [row for row in rows if not row.is_control], next((row for row in rows if row.is_control), None)))
    return [e for e in found if e.scene or e.transport or e.faults or e.control]


def judges(effects: list[EffectEvidence]) -> dict[str, str]:
    """The renderers that judged faults: name to title."""
    return {j.renderer: j.title for e in effects for fault in e.faults for j in fault.record.judgements}


def judgement(fault: Fault, name: str) -> Judgement | None:
    return next((j for j in fault.record.judgements if j.renderer == name), None)
