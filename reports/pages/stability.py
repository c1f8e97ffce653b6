"""The page of failure maps, if the stability suite has run."""

from __future__ import annotations

from comparisons.stability.outcome import KINDS

from ..failures import Cell
from ..report import Report
from .page import Page


def pages(report: Report) -> list[Page]:
    if report.failures is None:
        return []
    told = report.failures.document.kinds
    legend = [(kind, Cell(kind, 0.0 if kind == "correct" else 100.0, ""), told.get(kind, means))
              for kind, means in KINDS.items()]
    return [Page("stability.html", "stability.html.j2", {"failures": report.failures, "legend": legend})]
