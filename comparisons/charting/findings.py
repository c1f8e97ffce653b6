"""What the points of a subject say, in sentences with their numbers."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Literal

from ..bench.document import Clock
from .document import Point, Series

FEW = 10  # wrong pixels: where other renderers are asked for as good a picture
LITERAL, EXACT = "paper", "exact"  # ids of series
WORDS = {"wrong": "wrong", "visible": "visibly wrong"}

Cost = Callable[[Point], float | None]


def findings(series: list[Series], clock: Clock) -> list[str]:
    """A sentence for each thing that the points show; none where they do not."""
    of_hits, of_picture = (lambda p: p.hits and getattr(p.hits, clock).median,
                           lambda p: p.picture and getattr(p.picture, clock).median)
    sentences = [_against_the_step(series, "wrong", of_hits, "first hits cost {0:.3g} times less"),
                 _against_the_step(series, "wrong", lambda p: p.evaluations, "it evaluates f {0:.3g} times less often"),
                 _against_the_step(series, "visible", of_picture, "the whole picture costs {0:.3g} times less"),
                 _other_renderers(series, clock), _oracle(series)]
    return [sentence for sentence in sentences if sentence]


def _points(series: list[Series], kind: str) -> Iterator[tuple[Series, Point]]:
    return ((s, p) for s in series if s.kind == kind for p in s.points if p.accuracy)


def _against_the_step(series: list[Series], counted: Literal["wrong", "visible"], cost: Cost, tells: str) -> str:
    """The cheapest method without a pixel that is `counted`, against the cheapest literal step that gets as far."""
    count = lambda p: getattr(p.accuracy, counted)
    ours = [(cost(p), s, p) for s, p in _points(series, "first hits") if cost(p) is not None]
    clean = [entry for entry in ours if count(entry[2]) == 0]
    if not clean:
        return ""
    least, s, p = min(clean, key=lambda entry: entry[0])
    literal = [(c, p) for c, s, p in ours if s.id == LITERAL]
    if s.id == LITERAL or not literal or not least:
        return ""
    begin = f"at zero {WORDS[counted]} pixels the cheapest method is {_named(s, p)}"
    clean_steps = [(c, p) for c, p in literal if count(p) == 0]
    if clean_steps:
        c, step = min(clean_steps, key=lambda entry: entry[0])
        return f"{begin}: {tells.format(c / least)} than with the literal step that gets there, {step.value:g}"
    c, step = min(literal, key=lambda entry: entry[1].value)
    return (f"{begin}: {tells.format(c / least)} than with the literal step {step.value:g}, which still leaves "
            f"{count(step)} of {step.accuracy.pixels} pixels {WORDS[counted]}")


def _other_renderers(series: list[Series], clock: Clock) -> str:
    """How much longer another renderer takes to come down to FEW wrong pixels, what it builds included."""
    exact = next((p for s in series if s.id == EXACT for p in s.points if p.picture and p.accuracy), None)
    others = [(s, p) for s, p in _points(series, "converter") if p.picture]
    if exact is None or not others:
        return ""
    good = [(s, p) for s, p in others if p.accuracy.wrong <= FEW]
    if not good:
        s, p = min(others, key=lambda entry: entry[1].accuracy.wrong)
        return f"no other renderer comes down to {FEW} wrong pixels; the best is {_named(s, p)} with {p.accuracy.wrong}"
    whole = lambda p: getattr(p.picture, clock).median + (p.build.median if p.build else 0)
    s, p = min(good, key=lambda entry: whole(entry[1]))
    return (f"of the other renderers, {_named(s, p)} is the cheapest with at most {FEW} wrong pixels "
            f"({p.accuracy.wrong}); it takes {whole(p) / whole(exact):.3g} times as long as exact, building included")


def _oracle(series: list[Series]) -> str:
    """The oracle hands the truth through: any error of its is one of the measurement."""
    for _, p in ((s, p) for s, p in _points(series, "control") if s.id == "oracle"):
        a = p.accuracy
        if a.wrong or a.depth_max or a.color_max:
            return ("the measurement is broken: the oracle control, which hands the truth through, has "
                    f"{a.wrong} wrong pixels")
    return ""


def _named(s: Series, p: Point) -> str:
    return s.title + (f" at {p.label}" if p.label else "")
