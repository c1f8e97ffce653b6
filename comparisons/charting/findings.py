"""What the points of a subject say, in sentences with their numbers."""

from __future__ import annotations

from collections.abc import Callable, Iterator

from ..bench.results import Clock
from .results import Point, Series

FEW = 10  # wrong pixels: where other renderers are asked for as good a picture
LITERAL, EXACT = "paper", "exact"  # ids of series

Cost = Callable[[Point], float | None]


def findings(series: list[Series], clock: Clock) -> list[str]:
    """A sentence for each thing that the points show; none where they do not."""
    of_hits = lambda p: p.hits and getattr(p.hits, clock).median
    told = [_against_the_step(series, of_hits, "first hits cost {0:.3g} times less"),
            _against_the_step(series, lambda p: p.evaluations, "it evaluates f {0:.3g} times less often"),
            _other_renderers(series, clock), _oracle(series)]
    return [sentence for sentence in told if sentence]


def _points(series: list[Series], kind: str) -> Iterator[tuple[Series, Point]]:
    return ((s, p) for s in series if s.kind == kind for p in s.points if p.accuracy)


def _against_the_step(series: list[Series], cost: Cost, tells: str) -> str:
    """The cheapest method without a wrong pixel, against the largest literal step that gets as far."""
    ours = [(cost(p), s, p) for s, p in _points(series, "first hits") if cost(p) is not None]
    clean = [entry for entry in ours if entry[2].accuracy.wrong == 0]
    if not clean:
        return ""
    least, s, p = min(clean, key=lambda entry: entry[0])
    name = s.title + (f" ({p.label})" if p.label else "")
    literal = [(c, p) for c, s, p in ours if s.id == LITERAL]
    if s.id == LITERAL or not literal or not least:
        return ""
    clean_steps = [(c, p) for c, p in literal if p.accuracy.wrong == 0]
    if clean_steps:
        c, step = min(clean_steps, key=lambda entry: entry[0])
        return (f"at zero wrong pixels the cheapest method is {name}: {tells.format(c / least)} than with the literal "
                f"step that gets there, {step.value:g}")
    c, step = min(literal, key=lambda entry: entry[1].value)
    return (f"at zero wrong pixels the cheapest method is {name}: {tells.format(c / least)} than with the literal step "
            f"{step.value:g}, which still leaves {step.accuracy.wrong} of {step.accuracy.pixels} pixels wrong")


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
