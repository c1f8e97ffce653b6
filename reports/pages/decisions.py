"""The page of the reference's decisions."""

from __future__ import annotations

from ..report import Report
from .page import Page


def pages(report: Report) -> list[Page]:
    return [Page("decisions.html", "decisions.html.j2", nav="Decisions")]
