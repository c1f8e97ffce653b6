"""Hold a picture against proofs, exact decisions and high-precision paths.

examples:
  raytruth certify figure-07-torus --size 160x120
  raytruth certify                                        every shipped scene
  raytruth certify my-scene.json --method interval --sample 5000 --paths 50
  raytruth certify figure-09-heart --method paper         how often does the document's own method fail?
  raytruth certify --random 1000 --seed 1                 a thousand random scenes of one object, against 60 digits

Every ray of the picture (camera, reflection, refraction and shadow rays) is decided once more by outward-rounded
interval arithmetic: a proof. python-flint decides a sample of them exactly, tangency included, half of it at
silhouettes and shadow edges. A few whole pixels are recomputed with 77 digits. The exit code is 1 if anything
contradicts.

With --random no scene is given: scene K of the random ones is drawn from the seed K, rendered, and sixteen of its pixels
are held against python-flint's numbers of 60 digits, which share no line of code with the tracer. Scenes that fail are
written to the folder of -o. The exit code is 1 if a decided pixel is wrong, a scene cannot be rendered, or more than 1 %
of a kind's hits are undecided although the 60 digits decide them; pairs of objects at one distance and formulas that are
not defined everywhere may stay undecided.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path

from raytruth.reference_tracer.text import hanging, table

from .. import memory
from ..arguments import add_engine, resized, size, whole
from ..compile_time import compile_time_announced

# bytes a pixel beside the picture's: twice the most that was found, by `/usr/bin/time -v raytruth certify figure-07-torus
# --size 1600x1200 --paths 0` (1195 MiB, where `estimate.memory` counts 965 for the picture alone)
BESIDE = 250


def add_arguments(parser):
    parser.add_argument("scene", nargs="*", help="names of shipped scenes or paths of files (default: all shipped)")
    parser.add_argument("--size", metavar="WxH", type=size, help="picture size instead of the scene's")
    parser.add_argument("--method", default="exact", help="the first-hit method to certify (default exact)")
    parser.add_argument("--sample", type=whole(0), default=1000, metavar="N", help="rays to decide exactly (default 1000)")
    parser.add_argument("--paths", type=whole(0), default=16, metavar="N", help="pixels to recompute (default 16)")
    parser.add_argument("--threads", type=whole(1, 1024), metavar="N", help="threads to use (default: all cores)")
    memory.add_argument(parser)
    parser.add_argument("--json", action="store_true", help="print a JSON list for programs")
    parser.add_argument("--random", type=int, metavar="N", help="certify N random scenes instead, those of the seeds "
                                                                "--seed, --seed + 1, ...")
    parser.add_argument("--seed", type=int, default=0, metavar="K", help="the first random scene (default 0)")
    add_engine(parser, "random scenes", 64)  # scenes that are named take all cores, one after another
    parser.add_argument("-o", "--results", type=Path, metavar="DIR", default=Path("results/random"),
                        help="folder for random scenes that fail (default results/random)")


def run(arguments) -> int:
    return _run(arguments) if arguments.random is None else _run_random(arguments)


def _run(arguments) -> int:
    from raytruth.reference_tracer.scene import library
    from raytruth.reference_tracer.tracer.film import PLANES

    scenes = [library.find(name) for name in arguments.scene or library.names()]
    scenes = [resized(scene, arguments.size) for scene in scenes]
    for scene in scenes:
        memory.require(scene, PLANES, BESIDE, arguments.memory)
    if arguments.cluster:
        return _told(_by_cluster(scenes, arguments), arguments)
    return _told(_here(scenes, arguments), arguments)


def _here(scenes, arguments):
    """The certificates of the scenes, each as it is finished."""
    from raytruth.comparisons.progress import Progress
    from raytruth.reference_tracer.certify import certify

    with Progress(len(scenes)) as bar:
        for k, scene in enumerate(scenes):
            def show(stage: str, share: float, done=k, name=scene.name):
                bar.label = f"{name}: {stage}"
                bar.to(done + share)
            with compile_time_announced(scene, bar):
                c = certify(scene, arguments.method, sample=arguments.sample, paths=arguments.paths,
                            threads=arguments.threads, progress=show)
            if not arguments.json:
                bar.close()
            yield c


def _by_cluster(scenes, arguments):
    """The same, or of a scene that has none its name and why."""
    from raytruth.comparisons import certificates
    from raytruth.comparisons.progress import Cases

    with Cases() as progress:
        for name, found in certificates.run(scenes, arguments.cluster, progress, method=arguments.method,
                                            sample=arguments.sample, paths=arguments.paths, threads=arguments.threads):
            yield f"{name}: no certificate: {found}" if isinstance(found, str) else found


def _told(found, arguments) -> int:
    from raytruth.reference_tracer.certify.text import told

    certificates, failed = [], []
    for c in found:
        (failed if isinstance(c, str) else certificates).append(c)
        if isinstance(c, str):
            print(f"raytruth: {c}", file=sys.stderr)
        elif not arguments.json:
            print(told(c), end="\n\n", flush=True)
    if arguments.json:
        print(json.dumps([c.document() for c in certificates], indent=1))
    elif len(certificates) > 1:
        print(_summary(certificates))
    return 0 if all(c.passed for c in certificates) and not failed else 1


def _run_random(arguments) -> int:
    from raytruth.comparisons.progress import Progress
    from raytruth.comparisons.random_scenes import grammar, suite
    from raytruth.reference_tracer.errors import InputError

    if arguments.scene:
        raise InputError("--random draws its scenes: name none")
    for name, low, high in (("random", 1, 10_000_000), ("seed", 0, 10**12)):
        if not low <= getattr(arguments, name) <= high:
            raise InputError(f"--{name}: must be {low} to {high}; found {getattr(arguments, name)}")
    totals, stopped = {}, False
    with Progress(arguments.random, label="random scenes") as bar:
        try:
            for answer in suite.run(arguments.random, arguments.seed, arguments.jobs, arguments.method,
                                    arguments.cluster):
                one = suite.Total.of(answer)
                totals[answer.kind] = totals[answer.kind] + one if answer.kind in totals else one
                if not one.holds(answer.kind):
                    bar.close()
                    _tell_failure(answer, grammar.draw(answer.seed).scene, arguments)
                bar.step()
        except KeyboardInterrupt:
            done = max(sum(t.scenes for t in totals.values()) - arguments.jobs, 0)  # those under way are made again
            bar.close()
            print(f"stopped after {done} scenes; go on with --random {arguments.random - done} "
                  f"--seed {arguments.seed + done}", file=sys.stderr)
            stopped = True
    if arguments.json:
        print(json.dumps({kind: {**vars(total), "counts": dict(total.counts)} for kind, total in totals.items()}, indent=1))
    else:
        print(_table(totals))
    if stopped:
        raise KeyboardInterrupt
    return int(not all(total.holds(kind) for kind, total in totals.items()))


def _tell_failure(answer, scene: dict, arguments) -> None:
    """One line for a scene that fails alone, with the command that repeats it; the scene goes to a file."""
    from raytruth.reference_tracer.writing import atomically

    path = arguments.results / f"random-{answer.seed}.json"
    with atomically(path) as part:
        part.write_text(json.dumps(scene, indent=1))
    undecided = f"{answer.counts.get('avoidable_hits')} of {answer.counts.get('hits')} hits undecided"
    what = answer.fault or (f"{len(answer.wrong)} wrong, e.g. {answer.wrong[0]}" if answer.wrong else undecided)
    method = "" if arguments.method == "exact" else f" --method {arguments.method}"
    print(f"{answer.kind} ({', '.join(answer.traits)}): {what}; repeat: "
          f"raytruth certify --random 1 --seed {answer.seed}{method}; scene: {path}",
          file=sys.stderr if arguments.json else sys.stdout, flush=True)


def _table(totals) -> str:
    """What every kind of scene came to, and whether that holds."""
    from raytruth.comparisons.random_scenes.suite import EXCUSED, MOST_UNDECIDED, Total

    heads = ("random scenes", "scenes", "failed", "pixels", "untold", "wrong", "hits", "undecided", "avoidable", "share",
             "worst scene")
    rows = []
    for kind, t in [*sorted(totals.items()), ("all", sum(totals.values(), Total()))]:
        c, (most, hits, seed) = t.counts, t.worst
        worst = f"{most} of {hits}: seed {seed}" if most else "-"
        numbers = (t.scenes, t.faults, c["pixels"], c["unsettled"], t.wrong, c["hits"], c["undecided_hits"],
                   c["avoidable_hits"])
        rows.append((kind, *(f"{n:,}" for n in numbers), f"{t.undecided:.2%}", worst))
    missed = [f"{kind}: {what}" for kind, t in sorted(totals.items()) for what in t.missed(kind)]
    return "\n".join([table(heads, rows, left=(0, 10)), "",
                      hanging("untold:", "pixels that the oracle cannot tell; avoidable: undecided hits whose colour it knows, "
                                         "and their share of all hits"), "",
                      *([f"does not hold: {text}" for text in missed] or
                        ["holds: no scene failed, no decided pixel is wrong, and of no kind more than "
                         f"{MOST_UNDECIDED:.0%} of the hits is avoidably undecided "
                         f"(but {', '.join(EXCUSED)}: see --help)"])])


def _summary(certificates) -> str:
    total = lambda pick: sum(pick(c) for c in certificates)
    rays, undecided = total(lambda c: c.rays), total(lambda c: c.undecided_rays)
    wrong = total(lambda c: sum(k.wrong for k in c.kinds.values()))
    return (f"{len(certificates)} scenes, {total(lambda c: c.passed)} hold: {rays:,} rays, "
            f"{wrong} wrong, {undecided / max(rays, 1):.1e} undecided; "
            f"{total(lambda c: c.audit.rays):,} audited, {total(lambda c: c.audit.contradictions)} contradictions; "
            f"{total(lambda c: c.paths.paths)} paths, largest error "
            f"{max((c.paths.largest_error for c in certificates), default=0.0):.1e}, "
            f"{total(lambda c: len(c.paths.near_critical))} near-critical")
