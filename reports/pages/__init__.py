"""The pages of a report. A new kind of page is one module with a function `pages`, listed in SECTIONS.

A module whose page has a document of its own, beside the results, has its FILE and `read` as well; without the document
there is no page.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

from raytruth.comparisons.document import Record

from . import changes, decisions, evidence, front, guide, matrix, plan, published, scenes, speed, stability, transport
from .page import Page, Report, arrange

__all__ = ["READERS", "Page", "Report", "all_pages", "arrange"]

SECTIONS = {  # the entries of the bar, six at most, in its order, and the modules whose pages each leads to
    "Findings": (front, changes, guide, scenes),
    "Who agrees": (matrix,),
    "Effects": (evidence, transport),
    "Decisions": (decisions, published),
    "Where methods fail": (stability,),
    "Speed": (speed, plan),
}
READERS: dict[str, Callable[[Path], Record]] = {kind.FILE: kind.read for kinds in SECTIONS.values() for kind in kinds
                                                if hasattr(kind, "FILE")}


def all_pages(report: Report) -> list[Page]:
    return [replace(page, section=name) for name, kinds in SECTIONS.items() for kind in kinds for page in kind.pages(report)]
