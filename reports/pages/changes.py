"""What changed since an earlier run: better, worse, slower or faster, new and gone. Only with `raytruth report --against`."""

from __future__ import annotations

from dataclasses import dataclass

from raytruth.comparisons.results import Comparison, Results

from ..cases import Case
from ..text.words import VERDICTS
from .page import Page, Report, Summary

TOLD_ERROR, TOLD_TIME = 2.0, 1.5  # ratios from which a change is listed; no verdict hangs on them
ORDER = ("worse", "better", "slower", "faster", "new", "gone")


@dataclass(frozen=True)
class Change:
    """A comparison of two runs; `case` is None for one that is gone."""

    kind: str  # one of ORDER
    id: str
    case: Case | None
    before: Comparison | None
    error: tuple[float | None, float | None]  # of 99 % of all pixels, before and now
    seconds: tuple[float | None, float | None]


def pages(report: Report) -> list[Page]:
    if report.earlier is None:
        return []
    found = changes(report)
    groups = [(kind, [change for change in found if change.kind == kind]) for kind in ORDER]
    told = ", ".join(f"{len(group)} {kind}" for kind, group in groups if group)
    return [Page("changes.html", "changes.html.j2", {
        "groups": [group for group in groups if group[1]], "earlier": report.earlier, "told": told or "nothing changed",
        "error": TOLD_ERROR, "time": TOLD_TIME,
    }, nav="What changed", summary=Summary("What changed", f"Against the run of {report.earlier.created}.",
                                           f"{told or 'nothing changed'}.".capitalize(), "What changed"))]


def changes(report: Report) -> list[Change]:
    """All that is worth telling, in the order of ORDER, then of the comparisons' names. One may be worse and slower."""
    before, now = {c.id: c for c in report.earlier.comparisons}, {case.comparison.id: case for case in report.cases}
    found = []
    for id, case in now.items():
        old = before.get(id)
        if old is None:
            found.append(Change("new", id, case, None, (None, _error(case.comparison)),
                                (None, _seconds(report.results, case.comparison))))
            continue
        about = (id, case, old, (_error(old), _error(case.comparison)),
                 (_seconds(report.earlier, old), _seconds(report.results, case.comparison)))
        found += [Change(kind, *about) for kind in (_quality(old, case.comparison, about[3]), _pace(about[4])) if kind]
    found += [Change("gone", id, None, old, (_error(old), None), (_seconds(report.earlier, old), None))
              for id, old in before.items() if id not in now]
    return sorted(found, key=lambda change: (ORDER.index(change.kind), change.id))


def _quality(old: Comparison, new: Comparison, error: tuple[float | None, float | None]) -> str:
    """By the verdict; by the error where that is the same."""
    order = list(VERDICTS)
    if old.verdict != new.verdict:
        return "worse" if order.index(new.verdict) < order.index(old.verdict) else "better"
    return _ratio(error, TOLD_ERROR, "worse", "better")


def _pace(seconds: tuple[float | None, float | None]) -> str:
    return _ratio(seconds, TOLD_TIME, "slower", "faster")


def _ratio(values: tuple[float | None, float | None], told: float, more: str, less: str) -> str:
    old, new = values
    if old is None or new is None:
        return ""
    return more if new > told * old else less if old > told * new else ""


def _error(comparison: Comparison) -> float | None:
    return comparison.metrics.get("color p99")


def _seconds(results: Results, comparison: Comparison) -> float | None:
    timing = next((run.timing for run in results.runs if run.key == comparison.test), None)
    return timing and (timing.warm or timing.first)

