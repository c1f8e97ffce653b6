"""Time the tracer against others: python -m raytruth.comparisons.bench

examples:
  python -m raytruth.comparisons.bench                                           everything, into results/bench.json
  python -m raytruth.comparisons.bench --quick                                   smaller pictures
  python -m raytruth.comparisons.bench --only paper-vs-port --scenes figure-07-torus --turns 5
  python -m raytruth.comparisons.bench --accept                                  what is reached now must not be lost again

The exit code is 1 if a ratio fell below 0.85 of the accepted one, or if a case crashed.
"""

from __future__ import annotations

import argparse
import re
import sys
from pathlib import Path

from raytruth.reference_tracer.errors import InputError

from .. import document as documents
from ..results import BROKEN
from . import cases, document, measure
from .document import FILE, Bench, Fall, Row, Spread

HEAD = (f"{'row':<50}{'value':>9}  {'bar':>9}  {'':5} {'wall (low to high)':<26}{'cpu (low to high)':<26}"
        f"{'turns':>5}{'others':>7}  seconds")


def main(arguments: list[str] | None = None) -> int:
    chosen = _parser().parse_args(arguments)
    if chosen.size and chosen.size != "own" and not re.fullmatch(r"[1-9]\d{0,4}x[1-9]\d{0,4}", chosen.size, re.ASCII):
        raise InputError(f"--size: must be WIDTHxHEIGHT or own; found {chosen.size!r}")
    if not 1 <= chosen.turns <= 1000:
        raise InputError(f"--turns: must be 1 to 1000; found {chosen.turns}")
    options = cases.Options(chosen.turns, chosen.size, chosen.clock, chosen.budget, chosen.quick)
    before = document.read_accepted(document.ACCEPTED) if document.ACCEPTED.exists() else None
    print(HEAD)
    bench = measure.run(cases.find(chosen.only), options, chosen.scenes, tell=lambda row: print(line(row), flush=True))
    partial = bool(chosen.only or chosen.scenes or chosen.size or chosen.quick)
    output = chosen.output or (None if partial else Path("results") / FILE)
    if output:
        documents.write(bench, output)
    falls = document.falls(bench, before) if before else []
    print(summary(bench, falls, output))
    if chosen.accept:
        document.accept(bench, before, document.ACCEPTED)
        return 0
    return 1 if falls or any(row.state in BROKEN for row in bench.rows) else 0


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser("python -m raytruth.comparisons.bench", description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", nargs="+", default=[], metavar="GROUP", help=f"groups: {', '.join(cases.GROUPS)}")
    parser.add_argument("--scenes", nargs="+", default=[], metavar="NAME", help="cases of these names only")
    parser.add_argument("--turns", type=int, default=5, help="how often each contestant runs (default 5)")
    parser.add_argument("--size", metavar="WxH", help="picture size of shipped scenes, or own for the scenes' own")
    parser.add_argument("--clock", choices=("wall", "cpu"), help="which decides (default: wall on a quiet machine)")
    parser.add_argument("--budget", type=float, default=120.0, metavar="SECONDS",
                        help="no new turn of a case begins that would end later than this (default 120)")
    parser.add_argument("--quick", action="store_true", help="smaller pictures, fewer samples")
    parser.add_argument("--accept", action="store_true", help="accept what is measured now")
    parser.add_argument("-o", "--output", type=Path, metavar="FILE", help="where to write the rows as JSON")
    return parser


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


if __name__ == "__main__":
    try:
        sys.exit(main())
    except InputError as error:
        print(f"python -m raytruth.comparisons.bench: {error}", file=sys.stderr)
        sys.exit(2)
