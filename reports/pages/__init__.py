"""The pages of a report. A new kind of page is one module with a function `pages`, listed in KINDS.

A module whose page has a document of its own, beside the results, has its FILE and `read` as well; without the document
there is no page.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from comparisons.document import Record

from . import decisions, evidence, matrix, plan, scenes, speed, stability, transport
from .page import Page, Report, arrange

__all__ = ["READERS", "Page", "Report", "all_pages", "arrange"]

KINDS = (scenes, matrix, evidence, decisions, transport, stability, speed, plan)
READERS: dict[str, Callable[[Path], Record]] = {kind.FILE: kind.read for kind in KINDS if hasattr(kind, "FILE")}


def all_pages(report: Report) -> list[Page]:
    return [page for kind in KINDS for page in kind.pages(report)]
