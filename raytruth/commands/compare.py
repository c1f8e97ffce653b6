"""Run renderers against the reference and measure how far their pictures agree.

examples:
  raytruth compare                                       every scene, every renderer
  raytruth compare figure-07-torus my-scene.json         some scenes
  raytruth compare --renderers mitsuba-mesh,mitsuba-sdfgrid --largest 320

Every pair of renderers is compared as well; a renderer that the majority contradicts on a scene is the odd one out.
Each renderer works in a process of its own, under a time limit: a crash costs its own cases. Finished work is kept in
the results folder and reused; an interrupted run resumes. Results accumulate: what they say of other scenes stays.
The exit code is 1 if anything differs or failed, or if a worse setting of a renderer passes a limit marked as tight
on the scenes that come closest to it.
"""

from __future__ import annotations

import sys
from collections import Counter
from pathlib import Path

from raytruth.reference_tracer.text import hanging

from ..arguments import add_engine, number, require_folder, seen_from, whole

FIRST = 3, 12  # scenes, the quickest ones, after which a report is made while the rest is under way


def add_arguments(parser):
    parser.add_argument("scene", nargs="*", help="names of shipped scenes or paths of scene files (default: all shipped)")
    parser.add_argument("--renderers", metavar="A,B",
                        help="compare these (default: paper, mitsuba-native, mitsuba-mesh, embree, povray)")
    parser.add_argument("-o", "--results", metavar="DIR", type=Path, default=Path("results"), help="default: results")
    parser.add_argument("--largest", metavar="PIXELS", type=whole(8, 16384), default=640,
                        help="scenes with a longer side are compared at this size (default 640)")
    parser.add_argument("--limit", metavar="SECONDS", type=number(0.1, 1e6), default=300.0,
                        help="time limit of one run (default 300)")
    add_engine(parser, "runs made")
    parser.add_argument("--no-studies", action="store_true", help="leave out the sweeps of resolution and step size")
    parser.add_argument("--fresh", action="store_true", help="drop what the results say of other scenes and renderers")
    parser.add_argument("--report", metavar="DIR", type=Path, help="make this report as the work goes on: the first pages "
                        f"after {FIRST[0]} scenes")
    parser.add_argument("--json", action="store_true", help="print the results document")


def run(arguments) -> int:
    from raytruth import reports
    from raytruth.comparisons import renderers
    from raytruth.comparisons.agreement import records
    from raytruth.comparisons.agreement.tightness import TELLING
    from raytruth.comparisons.progress import Cases
    from raytruth.comparisons.results import BROKEN
    from raytruth.comparisons.suite import COMPARED, Options, compare
    from raytruth.comparisons.verdicts.tolerances import LOOSE
    from raytruth.reference_tracer.errors import InputError
    from raytruth.reference_tracer.scene import library

    chosen = tuple(arguments.renderers.split(",")) if arguments.renderers else COMPARED
    for name in chosen:
        renderers.find(name)
    scenes = [library.find(name) for name in arguments.scene or (*library.names(), *library.effects())]
    names = Counter(scene.name for scene in scenes)
    if twice := [name for name, count in names.items() if count > 1]:
        raise InputError(f"two scenes are named {twice[0]!r}; give each its own \"name\"")
    for folder in (arguments.results, arguments.report):
        require_folder(folder)
    with Cases("compare", arguments.results) as progress:
        for some in _rounds(scenes, arguments.results) if arguments.report else [scenes]:
            results = compare(some, Options(
                folder=seen_from(arguments.cluster, arguments.results), renderers=chosen, largest=arguments.largest,
                limit=arguments.limit, jobs=arguments.jobs, cluster=arguments.cluster, progress=progress,
                with_studies=some is scenes and not arguments.no_studies, fresh=arguments.fresh))
            if arguments.report:
                reports.build(arguments.results, arguments.report,
                              to_come=len(_missing(scenes, arguments.results)) * len(chosen))
    matrix = records.read(arguments.results)
    if arguments.json:
        print(results.model_dump_json(indent=1))
    else:
        _tell(results, matrix, arguments.results)
    here = {scene.name for scene in scenes}
    odd = any(not d.expected for d in matrix.dissent if d.scene in here)
    broken = any(run.state in BROKEN for run in results.runs) or any(not s.holds for s in results.series)
    # the scenes that come closest to the limits decide what is tight
    loose = here.issuperset(TELLING) and any(
        t.verdict == "loose" and t.tolerance not in LOOSE for t in matrix.tightness)
    return 1 if broken or odd or loose or any(c.verdict == "differs" for c in results.comparisons) else 0


def _rounds(scenes, folder: Path):
    """More and more of the scenes that have no results, and all at last: what is finished then is reused."""
    quickest = sorted(_missing(scenes, folder), key=lambda scene: (scene.tracing.samples, len(scene.objects)))
    return [*(quickest[:first] for first in FIRST if first < len(quickest)), scenes]


def _missing(scenes, folder: Path) -> list:
    from raytruth.comparisons import document
    from raytruth.comparisons.results import COMMAND, FILE, Results

    found = document.found(folder / FILE, Results, COMMAND)
    known = {scene.name for scene in found.scenes} if found else set()
    return [scene for scene in scenes if scene.name not in known]


def _tell(results, matrix, folder) -> None:
    order = {"not compared": 0, "differs": 1, "expected": 2, "agrees": 3}
    for c in sorted(results.comparisons, key=lambda c: (order[c.verdict], c.id)):
        print(hanging(f"{c.verdict:<13} {c.id:<45}", c.reason))
    for s in results.series:
        print(hanging(f"{'holds' if s.holds else 'fails':<13} {s.id:<45}", f"slopes {s.slope}"))
    for d in (d for d in matrix.dissent if d.scene in {scene.name for scene in results.scenes}):
        found = "split" if d.split else "expected" if d.expected else "odd one out"
        print(hanging(f"{found:<13} {d.scene:<45}", d.sentence))
    for t in matrix.tightness:
        print(hanging(f"{t.verdict:<13} {t.tolerance + ', ' + t.gate:<45}",
                      f"{t.worse}: {t.worse_share:.3g} of the limit; usual: {t.share:.3g}"))
    counts = Counter(c.verdict for c in results.comparisons)
    print(", ".join(f"{counts[v]} {v}" for v in order if counts[v]) + f"; results in {folder}", file=sys.stderr)
