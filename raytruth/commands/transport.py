"""Hold the document's model against Mitsuba's own light transport, one effect at a time.

examples:
  raytruth transport                          every case, into results/transport.json
  raytruth transport mirror hard-shadow       some cases
  raytruth transport --json -o results        the whole document, printed and written

Each case is set up with Mitsuba's stock plugins so that theory says the pictures must be equal; those marked "finding"
measure where physics and the document differ, and hold the difference against what physics predicts. Deterministic
pictures are held to a 99th percentile, Monte Carlo ones to a z-test of every pixel and the fall of the error. Every
case runs in a child process. The exit code is 1 if one fails.
"""

from __future__ import annotations

import sys
from pathlib import Path

from raytruth.reference_tracer.text import hanging

from ..arguments import add_engine, number, require_folder, seen_from


def add_arguments(parser):
    parser.add_argument("case", nargs="*", help="ids of cases (default: all)")
    parser.add_argument("-o", "--results", type=Path, metavar="DIR",
                        help="folder for transport.json (default: results, if every case is run)")
    parser.add_argument("--limit", type=number(0.1, 1e6), default=120.0, metavar="SECONDS",
                        help="time limit of a case (default 120)")
    add_engine(parser, "cases measured")
    parser.add_argument("--fresh", action="store_true", help="drop what the document held before")
    parser.add_argument("--json", action="store_true", help="print the document")


def run(arguments) -> int:
    from raytruth.comparisons.progress import Cases
    from raytruth.comparisons.transport import cases, measure
    from raytruth.comparisons.transport import document as documents

    chosen = cases.find(arguments.case)
    folder = arguments.results or Path("results")
    require_folder(folder)
    with Cases("transport", folder) as progress:
        document = measure.run(chosen, seen_from(arguments.cluster, folder), limit=arguments.limit, jobs=arguments.jobs,
                               progress=progress, cluster=arguments.cluster)
    if arguments.results or not arguments.case:
        documents.keep(document, folder, arguments.fresh)
        print(f"written to {folder / documents.FILE}", file=sys.stderr)
    if arguments.json:
        print(document.model_dump_json(indent=1))
    else:
        for case in document.cases:
            verdict = "not measured" if case.state != "ok" else "differs" if not case.holds else {
                "equal": "agrees", "finding": "finding"}[case.kind]
            print(hanging(f"{verdict:<13} {case.effect:<17} {case.id:<25}", case.reason))
    return 1 if document.failed else 0
