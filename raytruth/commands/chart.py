"""Chart speed against accuracy: every first-hit method and every renderer over its own parameter, and how time grows.

examples:
  raytruth chart                                     a few scenes and surfaces, in little more than a minute
  raytruth chart figure-07-torus surface-gyroid      some of them, or scene files
  raytruth chart --full                              every scene and every single surface, every value; takes far longer
  raytruth chart --growth threads                    one study of growth alone

Accuracy is recomputed from the pictures, against proven first hits. Times are medians of interleaved turns; compiling
and building are told apart. Renderers run in child processes: a crash costs its own points, finished ones are kept.
The exit code is 1 if a renderer crashed, hung or answered nonsense.
"""

from __future__ import annotations

import sys
from pathlib import Path

from ..arguments import number, require_folder, size, whole


def add_arguments(parser):
    parser.add_argument("scene", nargs="*", help="shipped scenes, scene files, or single surfaces (default: a few)")
    parser.add_argument("--full", action="store_true", help="all scenes and surfaces, all values of every parameter")
    parser.add_argument("--growth", action="append", default=[], metavar="STUDY",
                        help="this study of growth, and no scene unless named (repeatable)")
    parser.add_argument("--size", metavar="WxH", type=size, default=(320, 240),
                        help="of the pictures (default 320x240)")
    parser.add_argument("--turns", type=whole(1, 1000), default=3, metavar="N", help="timed runs of each point (default 3)")
    parser.add_argument("--limit", type=number(0.1, 1e6), metavar="SECONDS",
                        help="time limit of one run (default 30; with --full 120)")
    parser.add_argument("-o", "--results", type=Path, metavar="DIR",
                        help="folder for chart.json (default: results, if nothing was chosen)")
    parser.add_argument("--fresh", action="store_true", help="drop what the document held before")
    parser.add_argument("--json", action="store_true", help="print the document")


def run(arguments) -> int:
    from raytruth.comparisons.charting import cases, document, measure
    from raytruth.comparisons.progress import Cases
    from raytruth.reference_tracer.errors import InputError

    limit = arguments.limit if arguments.limit is not None else 120.0 if arguments.full else 30.0
    if not 8 <= min(arguments.size) or arguments.size[0] * arguments.size[1] > 1 << 24:
        raise InputError(f"--size: sides must be at least 8 and all pixels at most {1 << 24}; found "
                         f"{arguments.size[0]}x{arguments.size[1]}")
    studies = cases.find_studies(arguments.growth, arguments.full) if arguments.growth or not arguments.scene else ()
    charted = cases.chosen(arguments.scene, arguments.full, arguments.size) \
        if arguments.scene or not arguments.growth else []
    folder = arguments.results or Path("results")
    require_folder(folder)
    with Cases("chart", folder) as progress:
        chart = measure.run(charted, studies, measure.Options(
            folder, arguments.full, arguments.turns, limit, patience=30.0 if arguments.full else 0.5, progress=progress))
    if arguments.results or not (arguments.scene or arguments.growth):
        document.keep(chart, folder, arguments.fresh)
        print(f"written to {folder / document.FILE}", file=sys.stderr)
    if arguments.json:
        print(chart.model_dump_json(indent=1))
    else:
        _tell(chart)
    return 1 if chart.faults else 0


def _tell(chart) -> None:
    for subject in chart.subjects:
        points = [p for s in subject.series for p in s.points]
        absent = sum(p.state in ("missing", "refused") for p in points)
        print(f"{subject.id}: {len(points) - absent} points on {subject.pixels} pixels"
              + (f", {absent} not to be had" if absent else ""))
        for sentence in subject.findings:
            print(f"  {sentence}")
    for growth in chart.growths:
        print(f"{growth.title}: {growth.finding}")
    for subject, what, message in chart.faults:
        print(f"FAILED {subject}: {what}: {message}")
    decides = "clock on the wall" if chart.clock == "wall" else "time of the processor"
    print(f"{chart.seconds:.0f} s; the {decides} decides", file=sys.stderr)
