"""What the document's text says and what its figures show, one switch at a time, and how near the shipped scenes come."""

from __future__ import annotations

import json
from dataclasses import dataclass
from importlib.resources import files

from ..cases import ShownEffect
from .page import Page, Report, Summary

NUMBERS = "published.json"  # written by tools/figures; the pictures that it was measured on are elsewhere


@dataclass(frozen=True)
class Switch:
    """A decision by which the figures differ from the text."""

    id: str
    name: str
    text: str  # what the text says
    figures: str  # what the figures show
    key: str  # in a scene file


SWITCHES = (
    Switch("E1", "The printed sine of refraction", "sin φ₂ = sin φ₁ · n₂/n₁, against the law of refraction above it",
           "the law, n₁/n₂", "tracing.refraction"),
    Switch("F1", "Several lights", "nothing; the reference adds them up", "1 − Π (1 − light), per channel", "tracing.lights"),
    Switch("F2", "Ambient light", "nothing; the reference has none", "figures 17 to 19 begin at 0.1 in place of 0",
           "tracing.ambient"),
    Switch("F3", "Shadows of transparent objects", "every crossing multiplies the light by the transparency",
           "objects that are transparent at all cast no shadow", "tracing.shadows"),
    Switch("F4", "The range of a ray", "each ray has its own", "a path shares one: a child has what its parent left",
           "tracing.range"),
    Switch("F5", "The camera’s axes", "unit vectors, nothing of right angles",
           "in figure 19 v_x and v_y stay the world’s when the camera turns", "camera.v_x, camera.v_y"),
    Switch("F6", "The heart’s normal", "the gradient of the printed polynomial, which vanishes on its belt",
           "black specks on the belt; the reference takes a form whose gradient does not vanish", ""),
)


@dataclass(frozen=True)
class Figure:
    """A figure of the document, and how near its scene comes; shares are percent of the pixels compared."""

    scene: str
    numbers: dict

    @property
    def figure(self) -> str:
        word = self.scene.split("-")[1]
        return str(int(word)) if word.isdigit() else f"the {word}"

    @property
    def left(self) -> str:
        """What is left in the figure's form, by class."""
        return ", ".join(f"{count} {name}" for name, count in self.numbers["left"].items()) or "nothing"

    def changed(self, switch: str) -> float | None:
        """The share of pixels that the switch alone changes by more than a grey level; None where the figure lacks it."""
        return next((s["alone"] for s in self.numbers["switches"] if s["id"] == switch), None)


def pages(report: Report) -> list[Page]:
    figures = [Figure(name, numbers) for name, numbers in read().items()]
    used = {s.id: [f for f in figures if f.changed(s.id) is not None] for s in SWITCHES}
    shown: dict[str, list[ShownEffect]] = {s.id: [e for e in report.effects if e.effect.decision == s.id] for s in SWITCHES}
    return [Page("published.html", "published.html.j2",
                 {"switches": SWITCHES, "figures": figures, "used": used, "shown": shown,
                  "scenes": {scene.name: scene for scene in report.results.scenes},
                  "columns": [s for s in SWITCHES if used[s.id]]},
                 nav="Text and figures", summary=Summary(
                     "Text and figures", "The document’s figures were not made by its text alone.", "",
                     "What the text says and what the figures show"))]


def read() -> dict[str, dict]:
    """What was measured against the published figures, by the scene's name; empty where nothing was."""
    source = files(__package__).joinpath("..", NUMBERS)
    return json.loads(source.read_text(encoding="utf-8")) if source.is_file() else {}
