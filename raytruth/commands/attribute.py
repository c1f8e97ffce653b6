"""Name the first stage at which two renderers part on a scene, with the worst pixels' rays side by side.

examples:
  raytruth attribute figure-17-scene1 --with mitsuba-mesh
  raytruth attribute my-scene.json --with paper --against exact --size 320x240
  raytruth attribute effect-shadow --with mitsuba-native --fault shadow-once     is a known fault found?
  raytruth attribute --wrong-on-purpose                 every fault before every judge, into results/attribution.json

Every stage of the document (camera, hit, root, normal, shading, shadow, reflection, refraction, mixing, sampling) is
asked by a scene derived from the given one that leaves all later stages nothing to do. What rounding explains never
counts. The exit code is 1 if a stage diverges, or if a fault made on purpose is not found or taken for another.
"""

from __future__ import annotations

import sys
from pathlib import Path

from raytruth.reference_tracer.text import hanging, side_by_side

from ..arguments import add_engine, require_folder, resized, seen_from, size


def add_arguments(parser):
    parser.add_argument("scene", nargs="?", help="name of a shipped scene or path of a scene file")
    parser.add_argument("--with", dest="renderer", metavar="RENDERER", help="the renderer to be judged")
    parser.add_argument("--against", metavar="RENDERER", default="exact", help="the renderer that judges (default exact)")
    parser.add_argument("--fault", metavar="NAME", help="judge the reference with this fault made on purpose, by --with")
    parser.add_argument("--size", metavar="WxH", type=size, default=(320, 240), help="picture size (default 320x240)")
    parser.add_argument("--wrong-on-purpose", action="store_true", help="put every fault before every judge")
    parser.add_argument("-o", "--results", metavar="DIR", type=Path, default=Path("results"), help="default: results")
    add_engine(parser, "attributions made")
    parser.add_argument("--json", action="store_true", help="print the document")


def run(arguments) -> int:
    from raytruth.reference_tracer.errors import InputError

    require_folder(arguments.results if arguments.wrong_on_purpose else None)
    if arguments.wrong_on_purpose:
        if arguments.scene or arguments.renderer or arguments.fault:
            raise InputError("--wrong-on-purpose: has scenes, judges and faults of its own; name none")
        return _all_faults(arguments)
    if arguments.cluster:
        raise InputError("--cluster: spreads --wrong-on-purpose; leave it out for one attribution")
    if not (arguments.scene and arguments.renderer):
        raise InputError("name a scene and --with RENDERER, or ask for --wrong-on-purpose")
    return _one(arguments)


def _one(arguments) -> int:
    from raytruth.comparisons import renderers
    from raytruth.comparisons.attribution.measure import attribute, of_fault, of_renderer
    from raytruth.comparisons.progress import Progress
    from raytruth.reference_tracer.scene.library import find

    both = ("exact" if arguments.fault is not None else arguments.against, arguments.renderer)
    near = renderers.nearest(resized(find(arguments.scene), arguments.size), *both)
    if arguments.fault is not None:
        a, b = of_renderer(arguments.renderer), of_fault(arguments.fault)
    else:
        a, b = of_renderer(arguments.against), of_renderer(arguments.renderer)
    with Progress(10) as bar:
        attribution = attribute(near.scene, a, b, progress=lambda stage: bar.step(label=stage))
    if near.words:
        attribution = attribution.model_copy(update={"sentence": f"{attribution.sentence}; compared with {near.words}"})
    if arguments.json:
        print(attribution.model_dump_json(indent=1))
    else:
        _tell(attribution)
    return 0 if attribution.stage is None else 1


def _tell(attribution) -> None:
    print(f"{attribution.scene}, {attribution.width} x {attribution.height}: {attribution.a} (a) and {attribution.b} (b)")
    print(attribution.sentence)
    print()
    for e in attribution.evidence:
        what = "; ".join(e.questions) if e.questions else "nothing of this kind in the scene, or an earlier stage diverges"
        count = f"{e.diverging} of {e.pixels}" if e.questions else ""
        print(hanging(f"{e.stage:<11} {e.outcome:<10} {count:>16}", what, gap=2))
    for pixel in attribution.pixels:
        print(f"\npixel row {pixel.row}, column {pixel.col} of: {attribution.shown_on}; difference {pixel.difference:.3g}")
        left, right = _lines(pixel.a, pixel.color_a), _lines(pixel.b, pixel.color_b)
        print(side_by_side(left, right))


def _lines(history, color) -> list[str]:
    """A pixel's rays on one side, one ray a line and a line of numbers below it."""
    vector = lambda v: "(" + " ".join(f"{c:.6g}" for c in v) + ")" if v else "-"
    lines = [history.renderer, f"colour {vector(color)}"]
    for ray in history.rays:
        share = f", weight {ray.weight:.4g}" if ray.weight is not None else ""
        lines.append(f"{ray.generation} {ray.kind}{share}: "
                     + (f"{ray.object} at t = {ray.t:.9g}" if ray.object and ray.t is not None else ray.object or "nothing"))
        if ray.object:
            lines.append(f"    point {vector(ray.point)}")
            lines.append(f"    normal {vector(ray.normal)}")
            lines.append(f"    lights {'-' if ray.lights is None else ray.lights}, own colour {vector(ray.color)}")
    return lines + ([f"({history.note})"] if history.note else [])


def _all_faults(arguments) -> int:
    from raytruth.comparisons.attribution.measure import wrong_on_purpose
    from raytruth.comparisons.progress import Cases

    with Cases("attribute", arguments.results) as progress:
        table = wrong_on_purpose(seen_from(arguments.cluster, arguments.results), jobs=arguments.jobs, progress=progress,
                                 cluster=arguments.cluster)
    if arguments.json:
        print(table.model_dump_json(indent=1))
    else:
        for row in table.rows:
            for j in row.judgements:
                named = j.message if j.state != "ok" else (
                    f"{'found' if j.found else 'not found'}, named {j.attribution.stage or 'nothing'}")
                print(hanging(f"{'holds' if row.holds else 'fails':<6} {row.title:<46} {row.effect:<24}",
                              f"{j.renderer:<15} {named}"))
        good = sum(row.holds for row in table.rows)
        print(f"{good} of {len(table.rows)} rows hold; written to {arguments.results / 'attribution.json'}", file=sys.stderr)
    return 0 if all(row.holds for row in table.rows) else 1
