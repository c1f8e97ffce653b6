"""The page of plans: what was decided for each scene, what it saves, and where the planned picture differs."""

from __future__ import annotations

import statistics
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from raytruth.comparisons.planning.document import FILE, Plan, Plans, read

from ..figures import scale
from ..figures.planes import NoPlanes, load
from ..text.words import VERDICTS, Verdict, count, slug
from .page import Page, Report, Summary

__all__ = ["FILE", "pages", "read"]

FOLDER = "images/plans"


@dataclass(frozen=True)
class ShownPlan:
    """A plan with its two pictures; `missing` says why there are none, if so."""

    record: Plan
    pixels: dict[str, np.ndarray]  # file to (h, w, 3) uint8
    missing: str

    @property
    def anchor(self) -> str:
        return slug(self.record.scene)

    @property
    def picture(self) -> str:
        return f"{FOLDER}/{self.anchor}-planned.png"

    @property
    def map(self) -> str:
        return f"{FOLDER}/{self.anchor}-change.png"

    @property
    def verdict(self) -> Verdict:
        return VERDICTS["agrees" if self.record.proof.holds else "differs"]

    @property
    def decided(self) -> list[str]:
        """The changes in a few words each, for the table of all scenes."""
        return [_short(d.parameter, d.planned) for d in self.record.decisions if d.changed]


def pages(report: Report) -> list[Page]:
    document = report.documents.get(FILE)
    if document is None or not document.plans:
        return []
    plans = [_shown(plan, report.folder) for plan in document.plans]
    kept = sum(plan.record.proof.holds for plan in plans)
    exact, paper = (median_ratio(document, method) for method in ("exact", "paper"))
    summary = Summary(
        "No more than a scene needs",
        f"{count(len(plans), 'scene')}, each planned by measuring to the least that keeps its picture within a tolerance.",
        f"{kept} of {len(plans)} keep it on the pixels held back; as written "
        f"they take {exact:.1f} times as long, in the median.",
        "The plans")
    return [Page("plan.html", "plan.html.j2", {"plans": plans, "kept": kept, "exact": exact, "paper": paper},
                 nav="Plans", summary=summary, pictures={file: p for plan in plans for file, p in plan.pixels.items()})]


def median_ratio(plans: Plans, what: str) -> float:
    """How many times longer scenes as written take than planned, by one of the ratios that are measured."""
    return statistics.median(getattr(plan.saved, what).value for plan in plans.plans)


def _shown(plan: Plan, folder: Path) -> ShownPlan:
    try:
        planes = load(plan.planes, folder, {"color": 3, "change": 0})
        color, change = planes["color"], planes["change"].astype(float)
        if change.shape != (plan.height, plan.width) or color.dtype != np.uint8:
            raise NoPlanes(f"{plan.planes} holds planes of another size or kind.")
    except NoPlanes as reason:
        return ShownPlan(plan, {}, str(reason))
    nothing = np.zeros(change.shape, bool)
    found = ShownPlan(plan, {}, "")
    found.pixels.update({found.picture: color,
                         found.map: scale.paint(np.where(np.isfinite(change), change, np.nan), nothing, nothing)})
    return found


def _short(parameter: str, planned: str) -> str:
    return f"no {parameter}" if planned == "left out" else f"{parameter}: {planned}"
