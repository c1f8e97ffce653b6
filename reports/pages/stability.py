"""The page of failure maps, if the stability suite has run."""

from __future__ import annotations

from comparisons.stability.document import KINDS
from comparisons.stability.document import FILE

from ..failures import Cell, failures
from ..report import Report
from .page import Page, Summary


def pages(report: Report) -> list[Page]:
    document = report.documents.get(FILE)
    if document is None:
        return []
    told = document.kinds
    legend = [(kind, Cell(kind, 0.0 if kind == "correct" else 100.0, ""), told.get(kind, means))
              for kind, means in KINDS.items()]
    shown = failures(document)
    count = len(document.findings)
    summary = Summary(
        "Where methods fail",
        f"{len(shown.methods)} methods on {len(shown.families)} families of cases, each with one difficulty that grows "
        "until methods break.",
        f"{count} {'finding' if count == 1 else 'findings'}." if count else
        "No law is broken, and no method that claims exactness is wrong without saying so.", "The failure maps")
    return [Page("stability.html", "stability.html.j2", {"failures": shown, "legend": legend},
                 nav="Where methods fail", summary=summary)]
