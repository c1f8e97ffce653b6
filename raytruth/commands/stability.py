"""Show where first-hit methods fail: families of cases with one difficulty each, exact answers and laws.

examples:
  raytruth stability                                    every method on every family, into results/stability.json
  raytruth stability --family grazing --family steep    some families
  raytruth stability --json -o results                  the whole document, printed and written

Every ray's answer is counted by kind: correct, missed, false, wrong root, diverged, non-finite, wrong value, undecided,
too slow. The table shows each method's most frequent failure at the hardest value of the difficulty. The exit code is
1 if a failure rate leaves the band of its law, or if a method that claims exactness is wrong without saying so.
"""

from __future__ import annotations

import sys
from pathlib import Path

from raytruth.reference_tracer.text import table

from ..arguments import add_engine, require_folder, seen_from, whole


def add_arguments(parser):
    parser.add_argument("--family", action="append", default=[], metavar="NAME",
                        help="run this family only (repeatable)")
    parser.add_argument("--rays", type=whole(1), default=400, metavar="N", help="rays at every value of p (default 400)")
    add_engine(parser, "families examined")
    parser.add_argument("-o", "--results", type=Path, metavar="DIR",
                        help="folder for stability.json (default: results, if every family is run)")
    parser.add_argument("--fresh", action="store_true", help="drop what the document held before")
    parser.add_argument("--json", action="store_true", help="print the document")


def run(arguments) -> int:
    from raytruth.comparisons.progress import Cases
    from raytruth.comparisons.stability import cases, measure
    from raytruth.comparisons.stability import document as documents
    from raytruth.reference_tracer.errors import InputError

    if not measure.FEWEST_RAYS <= arguments.rays <= measure.MOST_RAYS:
        raise InputError(f"--rays: must be {measure.FEWEST_RAYS} to {measure.MOST_RAYS}; found {arguments.rays}")
    chosen = cases.find(arguments.family)
    folder = arguments.results or (None if arguments.family else Path("results"))
    require_folder(folder)
    with Cases("stability", folder) as progress:
        document = measure.run(chosen, seen_from(arguments.cluster, folder or Path("results")), rays=arguments.rays,
                               jobs=arguments.jobs, progress=progress, cluster=arguments.cluster)
    if folder is not None:
        documents.keep(document, folder, arguments.fresh)
    if arguments.json:
        print(document.model_dump_json(indent=1))
    else:
        _tell(document)
        print(f"{len(chosen)} families, {document.rays} rays a point, {document.seconds:.0f} s"
              + (f"; written to {folder / documents.FILE}" if folder else ""), file=sys.stderr)
    return 1 if document.findings else 0


def _tell(document) -> None:
    methods = [m.name for m in document.methods if not m.wrong_variant]
    rows, variants = [], []
    for family in document.families:
        hold = all(law.holds for law in family.laws)
        laws = "" if not family.laws else "hold" if hold else "BROKEN"
        for precision, values in ((64, family.values), (32, family.values_single)):
            series = {s.method: s for s in family.series if s.precision == precision}
            if series:
                name = family.id if precision == 64 else f"{family.id} fp32"
                p = "any" if family.labels else f"{values[-1]:g}"
                rows.append((name, p, *(_cell(family, series.get(method)) for method in methods),
                             laws if precision == 64 else ""))
                variants += [(name, variant, _cell(family, series[variant]))
                             for variant in sorted(series.keys() - set(methods))]
    print(table(("family", "p", *methods, "laws"), rows, left=(0, *range(2, len(methods) + 3))))
    if variants:
        print()
        print(table(("family", "variant", ""), variants, left=(0, 1, 2)))
    for finding in document.findings:
        print(f"{finding.what.upper()}: {finding.family}: {finding.sentence}")


def _cell(family, series) -> str:
    """The most frequent failure at the hardest value of p, and how many of the rays it takes.

    Values with names of their own are not ordered: the worst of them is shown.
    """
    points = [p for p in series.points if p.counts] if series else []
    if not points:
        return "-"
    point = max(points, key=lambda p: p.rate(p.worst) if p.worst != "correct" else 0) if family.labels else points[-1]
    if point.worst == "correct":
        return "ok"
    rate = point.rate(point.worst)
    return f"{point.worst} {'<1%' if rate < 0.005 else f'{rate:.0%}'}"
