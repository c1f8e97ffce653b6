"""Time the tracer against other programs, in turns: ratios that must not fall.

examples:
  raytruth bench                                        everything, into results/bench.json; wants the machine to itself
  raytruth bench --quick                                smaller pictures
  raytruth bench --only paper-vs-port --scenes figure-07-torus --turns 5
  raytruth bench --accept                               what is reached now must not be lost again

The exit code is 1 if a ratio fell below 0.85 of the accepted one, or if a case crashed.
"""

from __future__ import annotations

from pathlib import Path

from ..arguments import number, require_folder, resized, size, whole


def add_arguments(parser):
    parser.add_argument("--only", nargs="+", default=[], metavar="GROUP", help="groups of cases, e.g. first-hits")
    parser.add_argument("--scenes", nargs="+", default=[], metavar="NAME", help="cases of these names only")
    parser.add_argument("--turns", type=whole(1, 1000), default=5, metavar="N",
                        help="how often each contestant runs (default 5)")
    parser.add_argument("--size", metavar="WxH", type=_size, help="picture size of shipped scenes, or own for the scenes' own")
    parser.add_argument("--clock", choices=("wall", "cpu"), help="which decides (default: wall on a quiet machine)")
    parser.add_argument("--limit", type=number(0.1, 1e6), default=120.0, metavar="SECONDS",
                        help="no new turn of a case begins that would end later than this (default 120)")
    parser.add_argument("--quick", action="store_true", help="smaller pictures, fewer samples")
    parser.add_argument("--accept", action="store_true", help="accept what is measured now")
    parser.add_argument("-o", "--results", type=Path, metavar="DIR",
                        help="folder for bench.json (default: results, if everything is timed)")
    parser.add_argument("--json", action="store_true", help="print the document")


def _size(text: str) -> str:
    return text if text == "own" else "{}x{}".format(*size(text))


def run(arguments) -> int:
    import sys

    from raytruth.comparisons import document as documents
    from raytruth.comparisons.bench import cases, document, measure, text
    from raytruth.comparisons.progress import Cases
    from raytruth.comparisons.results import BROKEN
    from raytruth.reference_tracer.scene import library

    chosen = cases.find(arguments.only)
    if arguments.size and arguments.size != "own":
        resized(library.scene("figure-05-sphere"), size(arguments.size))  # what a picture may have is the format's to say
    options = cases.Options(arguments.turns, arguments.size, arguments.clock, arguments.limit, arguments.quick)
    partial = bool(arguments.only or arguments.scenes or arguments.size or arguments.quick)
    folder = arguments.results or (None if partial else Path("results"))
    require_folder(folder)
    before = document.read_accepted(document.ACCEPTED) if document.ACCEPTED.exists() else None
    tell = lambda line: print(line, file=sys.stderr if arguments.json else sys.stdout, flush=True)
    tell(text.HEAD)
    with Cases("bench", folder) as progress:
        bench = measure.run(chosen, options, arguments.scenes, lambda row: tell(text.line(row)), progress)
    if folder:
        documents.write(bench, folder / document.FILE)
    falls = document.falls(bench, before) if before else []
    tell(text.summary(bench, falls, folder and folder / document.FILE))
    if arguments.json:
        print(bench.model_dump_json(indent=1))
    if arguments.accept:
        document.accept(bench, before, document.ACCEPTED)
        return 0
    return 1 if falls or any(row.state in BROKEN for row in bench.rows) else 0
