"""The page of plans: no more than a scene needs, if scenes have been planned."""

from __future__ import annotations

from comparisons.planning.document import FILE

from ..plans import median_ratio, shown
from ..report import Report
from .page import Page, Summary


def pages(report: Report) -> list[Page]:
    document = report.documents.get(FILE)
    if document is None or not document.plans:
        return []
    plans = shown(document, report.folder)
    proven = sum(plan.record.proof.holds for plan in plans)
    exact, paper = (median_ratio(document, method) for method in ("exact", "paper"))
    summary = Summary(
        "No more than a scene needs",
        f"{len(plans)} scenes, each planned by measuring to the least that keeps its picture within a tolerance.",
        f"{proven} of {len(plans)} are proven on pixels held back; in the median they render {exact:.1f} times faster.",
        "The plans")
    return [Page("plan.html", "plan.html.j2", {"plans": plans, "proven": proven, "exact": exact, "paper": paper},
                 nav="Plans", summary=summary, pictures={file: p for plan in plans for file, p in plan.pixels.items()})]
