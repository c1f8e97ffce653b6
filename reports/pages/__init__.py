"""The pages of a report. A new kind of page is one module with a function `pages`, listed in KINDS."""

from __future__ import annotations

from collections.abc import Callable

from ..report import Report
from . import decisions, effects, evidence, index, matrix, plan, scenes, speed, stability, transport
from .page import Page

KINDS: tuple[Callable[[Report], list[Page]], ...] = (index.pages, scenes.pages, matrix.pages, evidence.pages, effects.pages, transport.pages,
                                                     stability.pages, speed.pages, plan.pages, decisions.pages)


def all_pages(report: Report) -> list[Page]:
    return [page for kind in KINDS for page in kind(report)]
