"""The pages of the reference's decisions, and of what they change; the misprint of section 4.3.3.2 is always there."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from importlib.resources import files

from markupsafe import Markup

from ..cases import ShownEffect
from ..figures.charts import Axis, Line, chart
from ..text.words import slug
from .page import Page, Report, Summary

FIRST = "E1"  # the misprint
INDEX = 1.5  # of the glass a ray enters
ANGLE = 30.0  # of incidence, degrees: the example in the text
STEP = 0.5  # degrees between points of a curve


@dataclass(frozen=True)
class Decision:
    """One row of DECISIONS.md. Texts are Markdown of which only `code` is used; see `pieces`."""

    id: str
    section: str
    question: str
    decision: str


@dataclass(frozen=True)
class Group:
    """The effects of one decision."""

    id: str
    decision: Decision | None  # None: not one of those that the reference states
    effects: list[ShownEffect]

    @property
    def anchor(self) -> str:
        return self.id if self.decision else slug(self.id)


def pages(report: Report) -> list[Page]:
    decisions = read_decisions()
    length, direction = printed_direction(ANGLE)
    effects = Page("effects.html", "effects.html.j2", {
        "groups": by_decision(report.effects, decisions),
        "misprint": FIRST,
        "plot": refraction_chart(),
        "index": INDEX,
        "last": last_printed_angle(),
        "example": {"angle": ANGLE, "length": length, "off": direction - refracted(ANGLE, 1 / INDEX)},
    }, nav="Decisions’ effects", summary=Summary(
        "What a decision changes",
        "The document prints its formula for the angle of refraction the wrong way round, and leaves other questions open.",
        "", "What each decision changes in a picture"))
    changing = {FIRST} | {shown.effect.decision for shown in report.effects}
    return [effects, Page("decisions.html", "decisions.html.j2", {"decisions": decisions, "changing": changing},
                          nav="Decisions")]


def read_decisions() -> list[Decision]:
    """The rows of reference_tracer/DECISIONS.md, in its order."""
    return parse(files("raytruth.reference_tracer").joinpath("DECISIONS.md").read_text(encoding="utf-8"))


def parse(markdown: str) -> list[Decision]:
    """The rows of the table whose header is `id | section | question | decision`."""
    rows = [[cell.strip() for cell in line.strip().strip("|").split("|")]
            for line in markdown.splitlines() if line.lstrip().startswith("|")]
    header = ["id", "section", "question", "decision"]
    if header not in rows:
        raise ValueError("the decisions have no table with the columns " + ", ".join(header))
    return [Decision(*row) for row in rows[rows.index(header) + 2:]]


def pieces(text: str) -> list[tuple[bool, str]]:
    """`text` cut at its back quotes: (is code, text)."""
    return [(i % 2 == 1, piece) for i, piece in enumerate(re.split(r"`([^`]*)`", text)) if piece]


def prose(text: str) -> Markup:
    """Markdown of which only `code` is used."""
    return Markup("").join(Markup("<code>{}</code>" if code else "{}").format(piece) for code, piece in pieces(text))


def by_decision(found: list[ShownEffect], decisions: list[Decision]) -> list[Group]:
    """The misprint first, whether or not its effect was measured, then in the order of the decisions."""
    rows = {d.id: d for d in decisions}
    order = {id: k for k, id in enumerate([FIRST, *(id for id in rows if id != FIRST)])}
    ids = sorted({FIRST, *(shown.effect.decision for shown in found)}, key=lambda id: (order.get(id, len(order)), id))
    return [Group(id, rows.get(id), [s for s in found if s.effect.decision == id]) for id in ids]


def refracted(incidence: float, ratio: float) -> float | None:
    """The angle in degrees whose sine is `ratio` times that of `incidence`; None where no angle has that sine."""
    sine = ratio * math.sin(math.radians(incidence))
    return math.degrees(math.asin(sine)) if sine <= 1 else None


def printed_direction(incidence: float, index: float = INDEX) -> tuple[float, float]:
    """Length, and angle to the normal in degrees, of the refraction direction computed with the printed sine on entry.

    The direction formula below the misprint takes its tangential part from the incoming ray, times n1/n2, which is
    right; only its normal part, the cosine, comes from the printed sine. Needs an angle below `last_printed_angle`.
    """
    sine = math.sin(math.radians(incidence))
    along, down = sine / index, math.sqrt(1 - (sine * index) ** 2)
    return math.hypot(along, down), math.degrees(math.atan2(along, down))


def last_printed_angle(index: float = INDEX) -> float:
    """The angle of incidence, in degrees, from which on the printed sine exceeds 1 on entry."""
    return math.degrees(math.asin(1 / index))


def refraction_curves() -> list[Line]:
    """The angle of refraction over the angle of incidence, on entry from air into glass; the printed ones end at 90°."""
    angles, last = [k * STEP for k in range(int(90 / STEP) + 1)], last_printed_angle()
    below = [a for a in angles if a < last]
    end = [(last, 90.0)]
    return [Line("the law, n₁/n₂", [(a, refracted(a, 1 / INDEX)) for a in angles], 0, "plain"),
            Line("the sine as printed, n₂/n₁", [(a, refracted(a, INDEX)) for a in below] + end, 1, "plain"),
            Line("the direction a program then computes", [(a, printed_direction(a)[1]) for a in below] + end, 2, "plain"),
            Line("no refraction", [(0.0, 0.0), (90.0, 90.0)], 5, "plain")]


def refraction_chart() -> Markup:
    degrees = lambda value: f"{value:.0f}°"
    return chart("refraction", "Angle of refraction over angle of incidence by both formulas",
                 Axis(f"angle of incidence, from air into n = {INDEX:g}", [90.0], step=15, write=degrees),
                 Axis("angle of refraction", [90.0], step=15, write=degrees), refraction_curves())
