"""Find the least that a scene needs to be rendered to a tolerance, by measuring.

examples:
  raytruth plan figure-17-scene1 --tolerance 1e-3 -o planned.json    a planned scene, and why
  raytruth plan my-scene.json --size 320x240 --with-mesh             and which meshes would be as good
  raytruth plan                                                      every figure's scene, into results/plan.json

Decided are: objects that never show, which of shadow, reflection and refraction matter, from which weight on secondary
rays are traced and how many generations of them, the first-hit method of every kind of surface, samples, the range of
rays, double or single precision. A random half of the pixels decides. The other half, held back, is a sample on which
the plan has to hold: no channel of their pixels differs by more than the tolerance from the scene as written with exact
intersections, but for pixels that rounding alone may change as much; those are counted, and if they are more than 0.1 %
it does not hold. The exit code is 1 if a plan does not.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path

from raytruth.reference_tracer.text import hanging

from ..arguments import number, require_file, require_folder, resized, size

LEAST, MOST = 1e-9, 1.0  # tolerances
FEWEST_TURNS = 5  # pairs of runs that can tell which scene is faster


def add_arguments(parser):
    parser.add_argument("scene", nargs="*", help="names of shipped scenes or paths of files (default: every figure's)")
    parser.add_argument("--tolerance", type=number(LEAST, MOST), default=1e-3, metavar="T",
                        help="largest difference of any channel of a pixel (default 1e-3)")
    parser.add_argument("-o", "--output", type=Path, metavar="FILE.json", help="write the planned scene (of one scene)")
    parser.add_argument("--results", type=Path, metavar="DIR",
                        help="folder whose plan.json gets the plans (default: results, if no scene is named)")
    parser.add_argument("--size", metavar="WxH", type=size, help="picture size instead of the scene's")
    parser.add_argument("--limit", type=number(1, 3600), default=60.0, metavar="S", help="seconds to decide in (default 60)")
    parser.add_argument("--with-mesh", action="store_true", help="find the mesh resolution at which Mitsuba is as good")
    parser.add_argument("--json", action="store_true", help="print the document")


def run(arguments) -> int:
    from raytruth.comparisons.planning import document, measure
    from raytruth.comparisons.progress import Cases

    scenes = _scenes(arguments)
    folder = arguments.results or (None if arguments.scene else Path("results"))
    if folder is not None and (folder / document.FILE).exists():
        document.read(folder)  # before the work, not after it
    plans, lost = [], 0
    with Cases("plan", folder) as progress:
        for scene, planning in zip(scenes, measure.run(scenes, arguments.tolerance, folder, limit=arguments.limit,
                                                       with_mesh=arguments.with_mesh, progress=progress)):
            progress.close()
            if planning.plan is None:
                lost += 1
                print(f"raytruth: {scene.name}: not planned: {planning.state}: {planning.message}", file=sys.stderr)
                continue
            plans.append(planning.plan)
            if not arguments.json:
                print(text(planning.plan), end="\n\n", flush=True)
    if arguments.output and plans:
        _write(plans[0].planned, arguments.output)
    if arguments.json:
        print(document.document_of(plans).model_dump_json(indent=1))
    elif len(plans) > 1:
        print(_summary(plans))
    return 0 if not lost and all(plan.proof.holds for plan in plans) else 1


def _scenes(arguments):
    from raytruth.reference_tracer.errors import InputError
    from raytruth.reference_tracer.scene import library

    if arguments.output and len(arguments.scene) != 1:
        raise InputError("--output: holds one planned scene; name one scene to plan")
    require_file(arguments.output, ".json")
    require_folder(arguments.results)
    scenes = [library.find(name) for name in arguments.scene or library.names()]
    return [resized(scene, arguments.size) for scene in scenes]


def _write(planned: dict, path: Path) -> None:
    from raytruth.reference_tracer.writing import atomically

    with atomically(path) as part:
        part.write_text(json.dumps(planned, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
    print(f"written to {path}", file=sys.stderr)


def _summary(plans) -> str:
    import statistics

    exact = statistics.median(plan.saved.exact.value for plan in plans)
    paper = statistics.median(plan.saved.paper.value for plan in plans)
    return (f"{len(plans)} scenes, {sum(plan.proof.holds for plan in plans)} hold on the pixels held back; in the median "
            f"the scene as written takes {exact:.2f} x as long as the planned one with exact, {paper:.2f} x with paper")


def text(plan) -> str:
    """What was decided and why, how far it held on the pixels held back, what is saved."""
    head = f"{plan.scene}, {plan.width} x {plan.height}, tolerance {plan.tolerance:g}"
    widths = [max(len(row[k]) for row in map(_cells, plan.decisions)) for k in range(3)] if plan.decisions else []
    row = lambda d: "  ".join(cell.ljust(width) for cell, width in zip(_cells(d), widths))
    rows = [hanging("  " + row(d), d.evidence, gap=2) for d in plan.decisions]
    return "\n".join([head, *rows, f"  {_sampled(plan)}", f"  {_saved(plan.saved)}", *map(_mesh, plan.meshes)])


def _cells(d) -> tuple[str, str, str]:
    if d.withdrawn:
        return d.parameter, d.written, "withdrawn"
    return d.parameter, d.written, f"-> {d.planned}" if d.changed else "stays"


def _sampled(plan) -> str:
    proof = plan.proof
    verdict = "HOLDS" if proof.holds else "DOES NOT HOLD"
    excused = f"; rounding excuses {proof.excused} more (at most {proof.most_excused})" if proof.excused else ""
    attempt = f"; attempt {plan.attempts}" if plan.attempts > 1 else ""
    largest = f"largest difference {proof.largest:.2g}"
    return (f"{verdict} on {proof.held_back:,} pixels sampled and held back: {largest}{excused}{attempt}; "
            f"found in {plan.seconds:.0f} s, {plan.cpu_seconds:.0f} s of processor time")


def _saved(saved) -> str:
    ratios = (saved.exact, "with exact"), (saved.paper, "with paper"), (saved.call, "by whole calls with exact")
    times = ", ".join(f"{r.value:.2f} x ({r.spread.low:.2f} to {r.spread.high:.2f}) {how}" for r, how in ratios)
    return (f"{_speed(saved.exact, saved.turns)} as written by {saved.exact.clock} time, which takes {times} as long; "
            f"{saved.turns} turns; {saved.rays_planned:,} of {saved.rays_written:,} rays")


def _speed(ratio, turns: int) -> str:
    """FASTER only where every one of enough pairs of runs says so: by chance all would once in 2^turns."""
    if turns < FEWEST_TURNS:
        return f"SPEED NOT MEASURED (fewer than {FEWEST_TURNS} turns) against the scene"
    if ratio.spread.low > 1:
        return "FASTER than the scene"
    return "SLOWER than the scene" if ratio.spread.high < 1 else "NO FASTER, as far as turns can tell, than the scene"


def _mesh(trial) -> str:
    if trial.state != "ok":
        return f"  meshes of {trial.resolution}: {trial.state}, {trial.message}"
    if trial.over == 0:
        return f"  meshes of {trial.resolution}: as good, largest difference {trial.largest:.2g}"
    return f"  meshes of {trial.resolution}: {trial.over} pixels over the tolerance, up to {trial.largest:.2g}"
