"""Time the tracer against others: python -m comparisons.bench

examples:
  python -m comparisons.bench                                           everything, into results/bench.json
  python -m comparisons.bench --quick                                   smaller pictures
  python -m comparisons.bench --only paper-vs-port --scenes figure-07-torus --turns 5
  python -m comparisons.bench --accept                                  what is reached now must not be lost again

The exit code is 1 if a ratio fell below 0.85 of the accepted one, or if a case crashed.
"""

from __future__ import annotations

import argparse
import re
import sys
from pathlib import Path

from reference_tracer.errors import InputError

from .. import document
from ..results import BROKEN
from . import accepted, groups, suite, table
from .options import Options
from .results import FILE


def main(arguments: list[str] | None = None) -> int:
    chosen = _parser().parse_args(arguments)
    if chosen.size and chosen.size != "own" and not re.fullmatch(r"[1-9]\d{0,4}x[1-9]\d{0,4}", chosen.size, re.ASCII):
        raise InputError(f"--size: must be WIDTHxHEIGHT or own; found {chosen.size!r}")
    if not 1 <= chosen.turns <= 1000:
        raise InputError(f"--turns: must be 1 to 1000; found {chosen.turns}")
    options = Options(chosen.turns, chosen.size, chosen.clock, chosen.budget, chosen.quick)
    before = accepted.read(accepted.FILE) if accepted.FILE.exists() else None
    print(table.HEAD)
    bench = suite.run(groups.find(chosen.only), options, chosen.scenes,
                      tell=lambda row: print(table.line(row), flush=True))
    partial = bool(chosen.only or chosen.scenes or chosen.size or chosen.quick)
    output = chosen.output or (None if partial else Path("results") / FILE)
    if output:
        document.write(bench, output)
    falls = accepted.falls(bench, before) if before else []
    print(table.summary(bench, falls, output))
    if chosen.accept:
        accepted.write(bench, before, accepted.FILE)
        return 0
    return 1 if falls or any(row.state in BROKEN for row in bench.rows) else 0


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser("python -m comparisons.bench", description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", nargs="+", default=[], metavar="GROUP", help=f"groups: {', '.join(groups.GROUPS)}")
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


if __name__ == "__main__":
    try:
        sys.exit(main())
    except InputError as error:
        print(f"python -m comparisons.bench: {error}", file=sys.stderr)
        sys.exit(2)
