"""The page of all pairs of renderers as heat tables: a cell is two renderers, its colour the decade of their error."""

from __future__ import annotations

import math
from dataclasses import dataclass
from string import ascii_uppercase

from raytruth.comparisons.agreement.records import FILE, Dissent, Matrix, Member, Pair, Place, read

from ..cases import Absence, absences
from ..figures import scale
from ..figures.scale import css
from ..text.numbers import parts
from ..text.words import count, slug
from .page import Page, Report, Summary

__all__ = ["FILE", "pages", "read"]

LIGHT = 0.5  # of the colour table: above, black is read better than white


@dataclass(frozen=True)
class Cell:
    """Two renderers: `text` is the power of ten of their error, `style` one of agree, disagree, expected, same, absent."""

    text: str
    style: str
    colour: str = ""
    dark: bool = False  # whether the colour asks for white letters
    title: str = ""


@dataclass(frozen=True)
class Row:
    letter: str
    name: str
    cells: list[Cell]
    odd: bool


@dataclass(frozen=True)
class Table:
    place: Place | None  # None: all scenes
    anchor: str
    rows: list[Row]


@dataclass(frozen=True)
class Shown:
    document: Matrix
    overall: Table
    worst: Table  # the same by the worst pixel alone
    groups: list[tuple[str, list[Table]]]
    absent: list[Absence]

    @property
    def finding(self) -> str:
        """How many pairs agree, and whether anybody but the literal method is at odds with the others."""
        agreeing = sum(pair.agrees for pair in self.document.pairs)
        text = f"{agreeing} of {count(len(self.document.pairs), 'pair')} agree"
        odd = {d.scene for d in self.document.dissent if not d.expected}
        if odd:
            return f"{text}; on {count(len(odd), 'scene')} somebody is at odds with the others."
        return f"{text}; all others are the literal method’s misses." if self.document.dissent else f"{text}."


def pages(report: Report) -> list[Page]:
    document = report.documents.get(FILE)
    if document is None:
        return []
    found = shown(document)
    summary = Summary(
        "Who agrees with whom",
        f"Every two of {len(document.members)} renderers on {len(document.places)} scenes, not only each against the "
        "reference: who is wrong is settled by majority.", found.finding, "The matrix")
    return [Page("matrix.html", "matrix.html.j2", {"matrix": found, "kind": kind}, nav="Who agrees", summary=summary)]


def kind(dissent: Dissent) -> str:
    """"expected", "odd" (a majority contradicts it) or "split" (nobody can say)."""
    return "expected" if dissent.expected else "split" if dissent.split else "odd"


def shown(document: Matrix) -> Shown:
    tables = [_table(document, place) for place in document.places]
    groups = [("Figures of the document", [t for t in tables if not t.place.effect]),
              ("One effect each", [t for t in tables if t.place.effect])]
    titles = {place.name: place.title for place in document.places}
    absent = absences((a.renderer, a.state, a.reason, titles.get(a.scene, a.scene), "") for a in document.absent)
    return Shown(document, *(table for _, table in both(document)), [group for group in groups if group[1]], absent)


def both(document: Matrix) -> list[tuple[str, Table]]:
    """All scenes at once by what 99 % of the pixels keep, and by the worst pixel alone."""
    return [("99 % of all pixels", _overall(document)), ("the worst pixel", _overall(document, "color_max"))]


def exponent(error: float) -> str:
    """The power of ten at or above `error`: what it stays below."""
    return str(math.ceil(math.log10(error) - 1e-9)).replace("-", "\N{MINUS SIGN}")


def _table(document: Matrix, place: Place) -> Table:
    pairs = {frozenset((p.first, p.second)): p for p in document.pairs if p.scene == place.name}
    absent = {a.renderer: a for a in document.absent if a.scene == place.name}
    odd = {name for d in document.dissent if d.scene == place.name and not d.expected for name in d.renderers}

    def cell(a: Member, b: Member) -> Cell:
        for name in (a.name, b.name):
            if name in absent:
                return Cell("", "absent", title=f"{name}: {absent[name].reason}")
        pair = pairs.get(frozenset((a.name, b.name)))
        return _cell(pair, pair.color_p99) if pair else Cell("", "absent", title="not compared")

    return Table(place, f"m-{slug(place.name)}", _rows(document.members, cell, odd))


def _overall(document: Matrix, error: str = "color_p99") -> Table:
    """Every pair at its worst scene by that `error`; the title says which, and on how many they agree."""
    def cell(a: Member, b: Member) -> Cell:
        both = [p for p in document.pairs if {p.first, p.second} == {a.name, b.name}]
        if not both:
            return Cell("", "absent", title="no scene has both")
        worst = max(both, key=lambda p: math.inf if getattr(p, error) is None else getattr(p, error))
        agreeing = sum(p.agrees for p in both)
        found = _cell(worst, getattr(worst, error))
        disagree = "expected" if all(p.agrees or p.expected for p in both) else "disagree"
        return Cell(found.text, "agree" if agreeing == len(both) else disagree, found.colour, found.dark,
                    f"agree on {agreeing} of {len(both)} scenes; furthest apart on {worst.scene}: {_numbers(worst)}")

    return Table(None, "overall", _rows(document.members, cell, set()))


def _rows(members: list[Member], cell, odd: set[str]) -> list[Row]:
    letters = [ascii_uppercase[k] if k < 26 else str(k) for k in range(len(members))]
    return [Row(letter, a.name, [Cell("", "same") if a is b else cell(a, b) for b in members], a.name in odd)
            for letter, a in zip(letters, members)]


def _cell(pair: Pair, error: float | None) -> Cell:
    style = "agree" if pair.agrees else "expected" if pair.expected else "disagree"
    title = f"{pair.first} and {pair.second}: {_numbers(pair)}" + ("" if pair.agrees else f". {pair.broken}")
    if error is None or not math.isfinite(error):
        return Cell("?", style, css(scale.NON_FINITE), False, title)
    if error == 0:
        return Cell("=", style, css(scale.EXACT), True, title)
    level = scale.level(error)
    return Cell(exponent(max(error, scale.LOW)), style, css(scale.TABLE[level]),
                bool(level < LIGHT * scale.LEVELS), title)


def _numbers(pair: Pair) -> str:
    p99, largest = ("nothing finite" if error is None else str(parts(error)) for error in (pair.color_p99, pair.color_max))
    return (f"99 % of all pixels within {p99}, the largest difference {largest}, {pair.failing} visibly off, "
            f"{pair.mismatches} see another object (limits for {pair.tolerance})")
