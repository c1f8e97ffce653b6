"""The page of decisions with a visible effect; the misprint of section 4.3.3.2 is always there."""

from __future__ import annotations

from ..effects import FIRST, by_decision
from ..refraction import INDEX, last_printed_angle, printed_direction, refracted, refraction_plot
from ..report import Report
from .page import Page, Summary


ANGLE = 30.0  # of incidence, degrees: the example in the text


def pages(report: Report) -> list[Page]:
    length, direction = printed_direction(ANGLE)
    return [Page("effects.html", "effects.html.j2", {
        "groups": by_decision(report.effects, report.decisions),
        "misprint": FIRST,
        "plot": refraction_plot(),
        "index": INDEX,
        "last": last_printed_angle(),
        "example": {"angle": ANGLE, "length": length, "off": direction - refracted(ANGLE, 1 / INDEX)},
    }, nav="Decisions’ effects", summary=Summary(
        "What a decision changes",
        "The document prints its formula for the angle of refraction the wrong way round, and leaves other questions open.",
        "", "What each decision changes in a picture"))]
