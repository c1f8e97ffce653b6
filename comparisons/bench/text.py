"""The rows of a benchmark as lines of text."""

from __future__ import annotations

from pathlib import Path

from .document import Bench, Fall, Row, Spread

HEAD = (f"{'row':<50}{'value':>9}  {'bar':>9}  {'':5} {'wall (low to high)':<26}{'cpu (low to high)':<26}"
        f"{'turns':>5}{'others':>7}  seconds")


def line(row: Row) -> str:
    """A row as text, under HEAD."""
    if row.value is None:
        return f"{row.key:<50}{row.state}: {row.message}"
    verdict = {True: "holds", False: "FAILS", None: ""}[row.holds]
    bar = "" if row.bar is None else f"{row.sense} {_short(row.bar)}"
    seconds = ", ".join(f"{name} {s.wall:.3g}" for name, s in row.seconds.items())
    others = "" if row.others is None else f"{row.others:.2f}"
    clock = "" if row.clock is None else f" by {row.clock}"
    remarks = "; ".join(filter(None, (seconds + clock, row.picture, row.note)))
    return (f"{row.key:<50}{_short(row.value) + ' ' + row.unit:>9}  {bar:>9}  {verdict:5} {_spread(row.wall):<26}"
            f"{_spread(row.cpu):<26}{row.turns:>5}{others:>7}  {remarks}")


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
