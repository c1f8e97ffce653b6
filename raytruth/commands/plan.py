"""Find the least that a scene needs to be rendered to a tolerance, by measuring.

examples:
  raytruth plan figure-17-scene1 --tolerance 1e-3 -o planned.json    a planned scene, and why
  raytruth plan my-scene.json --size 320x240 --with-mesh             and which meshes would be as good
  raytruth plan                                                      every figure's scene, into results/plan.json

Decided are: objects that never show, which of shadow, reflection and refraction matter, from which weight on secondary
rays are traced and how many generations of them, the first-hit method of every kind of surface, samples, the range of
rays, double or single precision. A random half of the pixels decides. The other half, held back, proves: no channel of
their pixels differs by more than the tolerance from the scene as written with exact intersections, but for pixels that
rounding alone may change as much; those are counted, and if they are more than 0.1 % it is no proof. The exit code is 1
if there is none.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path

from ..arguments import number, require_file, require_folder, resized, size

LEAST, MOST = 1e-9, 1.0  # tolerances


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
    from comparisons.planning import results, suite
    from comparisons.planning.text import told
    from comparisons.progress import Cases

    scenes = _scenes(arguments)
    folder = arguments.results or (None if arguments.scene else Path("results"))
    if folder is not None and (folder / results.FILE).exists():
        results.read(folder)  # before the work, not after it
    plans, lost = [], 0
    with Cases() as progress:
        for scene, made in zip(scenes, suite.run(scenes, arguments.tolerance, folder, limit=arguments.limit,
                                                 with_mesh=arguments.with_mesh, progress=progress)):
            progress.close()
            if made.plan is None:
                lost += 1
                print(f"raytruth: {scene.name}: not planned: {made.state}: {made.message}", file=sys.stderr)
                continue
            plans.append(made.plan)
            if not arguments.json:
                print(told(made.plan), end="\n\n", flush=True)
    if arguments.output and plans:
        _write(plans[0].planned, arguments.output)
    if arguments.json:
        print(results.document_of(plans).model_dump_json(indent=1))
    elif len(plans) > 1:
        print(_summary(plans))
    return 0 if not lost and all(plan.proof.holds for plan in plans) else 1


def _scenes(arguments):
    from reference_tracer.errors import InputError
    from reference_tracer.scene import library

    if arguments.output and len(arguments.scene) != 1:
        raise InputError("--output: holds one planned scene; name one scene to plan")
    require_file(arguments.output, ".json")
    require_folder(arguments.results)
    scenes = [library.find(name) for name in arguments.scene or library.names()]
    return [resized(scene, arguments.size) for scene in scenes]


def _write(planned: dict, path: Path) -> None:
    from reference_tracer.errors import InputError

    try:
        path.write_text(json.dumps(planned, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
    except OSError as error:
        raise InputError(f"{path}: cannot be written ({error.strerror}); choose another file") from None
    print(f"written to {path}", file=sys.stderr)


def _summary(plans) -> str:
    import statistics

    exact = statistics.median(plan.saved.exact.value for plan in plans)
    paper = statistics.median(plan.saved.paper.value for plan in plans)
    return (f"{len(plans)} scenes, {sum(plan.proof.holds for plan in plans)} proven; in the median the planned scene "
            f"renders {exact:.2f} x faster than as written with exact, {paper:.2f} x than with paper")
