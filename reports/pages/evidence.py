"""The effects one by one: an overview, and a page for each."""

from __future__ import annotations

from ..evidence import evidence, judgement, judges
from ..report import Report
from .page import Page, Summary


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
