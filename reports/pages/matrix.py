"""The page of all pairs of renderers, if the comparison has run with this version."""

from __future__ import annotations

from comparisons.agreement.records import FILE

from ..matrix import kind, shown
from ..report import Report
from .page import Page, Summary


def pages(report: Report) -> list[Page]:
    document = report.documents.get(FILE)
    if document is None:
        return []
    found = shown(document)
    summary = Summary(
        "Who agrees with whom",
        f"Every two of {len(document.members)} renderers on {len(document.places)} scenes, not only each against the "
        "reference: who is wrong is settled by majority.", finding(found), "The matrix")
    return [Page("matrix.html", "matrix.html.j2", {"matrix": found, "finding": finding(found), "kind": kind},
                 nav="Who agrees", summary=summary)]


def finding(found) -> str:
    pairs, odd = len(found.document.pairs), found.odd
    excused = sum(d.expected for d in found.document.dissent)
    text = f"{found.agreeing} of {pairs} pairs agree"
    if odd:
        scenes = len({d.scene for d in odd})
        return f"{text}; on {scenes} {'scene' if scenes == 1 else 'scenes'} somebody is at odds with the others."
    return f"{text}; all others are the literal method’s misses." if excused else f"{text}."
