"""The pages of speed against accuracy, if that was charted: an overview, and one page a subject."""

from __future__ import annotations

from comparisons.charting.document import FILE

from ..report import Report
from ..speed import Speed
from ..words import sentence
from .page import Page, Summary


def pages(report: Report) -> list[Page]:
    document = report.documents.get(FILE)
    if document is None:
        return []
    speed = Speed(document)
    summary = Summary(
        "Speed against accuracy",
        f"Every first-hit method and every renderer over its own parameter, on {len(speed.subjects)} scenes and "
        "surfaces, against proven first hits.", sentence(speed.headline) if speed.headline else "", "The charts")
    return [Page("speed.html", "speed.html.j2", {"speed": speed}, nav="Speed", summary=summary)] + [
        Page(view.page, "speed_subject.html.j2", {"speed": speed, "view": view}) for view in speed.subjects]
