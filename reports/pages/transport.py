"""The page of Mitsuba's own light transport, if that suite has run."""

from __future__ import annotations

from itertools import groupby

from comparisons.transport.document import FILE

from ..report import Report
from ..transport import shown
from .page import Page, Summary


def pages(report: Report) -> list[Page]:
    document = report.documents.get(FILE)
    if document is None:
        return []
    cases = shown(document, report.folder)
    equal = [case for case in cases if case.record.kind == "equal"]
    findings = [case for case in cases if case.record.kind == "finding"]
    agree = sum(case.record.holds for case in equal)
    summary = Summary(
        "Mitsuba’s own light transport",
        f"{len(equal)} scenes, one effect each, that Mitsuba’s stock plugins must render as the document does, and "
        f"{len(findings)} that show where physics and the document differ.",
        f"{agree} of {len(equal)} agree." if agree < len(equal) else f"All {agree} agree.", "The light transport")
    return [Page("transport.html", "transport.html.j2", {
        "cases": cases,
        "effects": [(effect, list(group)) for effect, group in groupby(equal, key=lambda case: case.record.effect)],
        "findings": findings,
        "agree": agree,
        "equal": len(equal),
    }, nav="Light transport", summary=summary, pictures={file: p for case in cases for file, p in case.pixels.items()})]
