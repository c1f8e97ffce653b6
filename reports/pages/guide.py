"""How to read the report, with a glossary; and what to trust of it: what is proven, sampled and assumed."""

from __future__ import annotations

from raytruth.comparisons.verdicts.tolerances import table

from ..text.words import GLOSSARY
from .page import Page, Report

ORIGINS = {
    "derived": "follows from a formula",
    "measured": "is what a command measured, with room up to the next worse setting",
    "assumed": "was chosen; a command holds it against pictures it was not chosen by",
}


def pages(report: Report) -> list[Page]:
    limits = sorted(table(), key=lambda limit: list(ORIGINS).index(limit.origin))
    return [Page("reading.html", "reading.html.j2", {"glossary": GLOSSARY}, nav="How to read"),
            Page("trust.html", "trust.html.j2", {"limits": limits, "origins": ORIGINS,
                                                 "failed": report.absent}, nav="What to trust")]
