"""The rows of a benchmark as lines of text."""

from __future__ import annotations

from pathlib import Path

from raytruth.reference_tracer.text import hanging

from .document import Bench, Fall, Row, Spread

HEAD = f"{'row':<50}{'value':>9}  {'bar':>9}"


def line(row: Row) -> str:
    """A row as text, under HEAD."""
    if row.value is None:
        return hanging(f"{row.key:<50}", f"{row.state}: {row.message}")
    verdict = {True: "holds", False: "FAILS", None: ""}[row.holds]
    bar = "" if row.bar is None else f"{row.sense} {_short(row.bar)}"
    clocks = [f"{name} {_spread(spread)}" for name, spread in (("wall", row.wall), ("cpu", row.cpu)) if spread is not None]
    seconds = ", ".join(f"{name} {s.wall:.3g} s" for name, s in row.seconds.items())
    others = "" if row.others is None else f"other processes {row.others:.2f}"
    remarks = [", ".join(clocks) + (f", by {row.clock}" if row.clock else ""), f"{row.turns} turns" * bool(row.turns), others,
               seconds, row.picture, row.note]
    first = f"{row.key:<50}{_short(row.value) + ' ' + row.unit:>9}  {bar:>9}  {verdict:5}"
    return hanging(first, "; ".join(filter(None, remarks)))


def summary(bench: Bench, falls: list[Fall], output: Path | None) -> str:
    judged = [row for row in bench.rows if row.holds is not None]
    lines = [f"{sum(row.holds for row in judged)} of {len(judged)} bars hold, {bench.seconds:.0f} s"
             + (f"; written to {output}" if output else "")]
    lines += [f"SLOWER: {fall.key}: {_short(fall.now)}, accepted was {_short(fall.accepted)}: "
              f"{fall.share:.0%} of the speed is left" for fall in falls]
    return "\n".join(lines)


def _short(number: float) -> str:
    return f"{number:.3g}" if abs(number) < 1000 else f"{number:.0f}"


def _spread(spread: Spread | None) -> str:
    return "" if spread is None else f"{_short(spread.median)} ({_short(spread.low)} to {_short(spread.high)})"
