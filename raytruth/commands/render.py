"""Render a scene to a PNG, EXR or NPZ file.

examples:
  raytruth render figure-05-sphere -o sphere.png
  raytruth render my-scene.json -o out.exr --method paper --step-size 0.05
  raytruth render figure-17-scene1 -o out.png --size 640x480 --samples 4
  raytruth render figure-10-refraction-n0.8 -o figure.png --as-published --method paper
  raytruth render figure-07-torus -o torus.npz --with mitsuba-mesh --set resolution=128

PNG holds the 8-bit picture; EXR all planes (colour, depth, position, normal, object, status) as floats; NPZ all
planes in full double precision. A picture that takes long is told what it will take before the work starts.
"""

from __future__ import annotations

import json
import sys
import time
from pathlib import Path

from .. import memory
from ..arguments import size, whole
from ..compile_time import compile_time_announced

MUCH = 1 << 22  # rays or steps at most: less than that takes a few seconds at most, and is not estimated
LONG = 3.0  # seconds from which on an estimate is told
COPIES = {".png": 3, ".exr": 160, ".npz": 0}  # bytes a pixel that writing a file takes
OF_OURS = ("method", "precision", "device", "threads", "memory")


def add_arguments(parser):
    parser.add_argument("scene", help="name of a shipped scene or path of a scene file")
    parser.add_argument("-o", "--output", required=True, metavar="FILE", help="ends in .png, .exr or .npz")
    parser.add_argument("--method", help="first-hit method: exact (default), paper, descartes, interval, proof")
    parser.add_argument("--with", dest="renderer", metavar="RENDERER",
                        help="another renderer, e.g. mitsuba-native, mitsuba-mesh, embree or povray")
    parser.add_argument("--set", dest="settings", action="append", default=[], metavar="KEY=VALUE",
                        help="a setting of that renderer, e.g. resolution=128")
    parser.add_argument("--as-published", action="store_true", help="as the document's figure shows it, not as its text says "
                        "(elsewhere: SCENE@published)")
    parser.add_argument("--size", metavar="WxH", type=size, help="picture size instead of the scene's")
    parser.add_argument("--samples", type=whole(-1), metavar="N", help="N x N samples a pixel instead of the scene's")
    parser.add_argument("--step-size", type=float, metavar="H", help="step size instead of the scene's")
    parser.add_argument("--tracing", action="append", default=[], metavar="KEY=VALUE",
                        help="any other parameter of the scene's \"tracing\", e.g. max_depth=1")
    parser.add_argument("--camera", action="append", default=[], metavar="KEY=VALUE",
                        help="of the scene's camera, e.g. fov=50 or v_x=[1,0,0]")
    parser.add_argument("--precision", type=int, choices=(64, 32), help="bits of the floats (default: the scene's, 64)")
    parser.add_argument("--device", choices=("llvm", "cuda"), help="processor (llvm, default) or graphics card (cuda)")
    parser.add_argument("--threads", type=whole(-1), metavar="N", help="threads to use (default: all cores)")
    memory.add_argument(parser)
    parser.add_argument("--json", action="store_true", help="print what was made as JSON")


def run(arguments) -> int:
    from raytruth.reference_tracer.errors import InputError
    from raytruth.reference_tracer.scene.library import PUBLISHED, find
    from raytruth.reference_tracer.tracer.image_files import require_writable, save

    output = Path(arguments.output)
    require_writable(output)  # before the work, not after it
    if arguments.renderer is None and arguments.settings:
        raise InputError(f"--set {arguments.settings[0]}: is a setting of the renderer that --with names; name one")
    if arguments.renderer is not None:
        for name in OF_OURS:
            if getattr(arguments, name) is not None:
                raise InputError(f"--{name}: is an option of raytruth's own tracer; leave it out with --with "
                                 f"{arguments.renderer}, which takes its settings by --set")
    scene = _adjusted(find(arguments.scene + PUBLISHED * arguments.as_published), arguments)
    start = time.perf_counter()
    picture = _with_other_renderer(scene, arguments) if arguments.renderer else _with_ours(scene, arguments)
    picture.metadata.setdefault("seconds", time.perf_counter() - start)  # others tell their phases
    save(picture, output)
    counts = {name: int((picture.status == code).sum()) for name, code in (("miss", 0), ("hit", 1), ("undecided", 2))}
    if arguments.json:
        print(json.dumps({"file": str(output), "pixels": counts, **picture.metadata}))
    else:
        rays = f"{picture.metadata['rays']:,} rays in " if "rays" in picture.metadata else ""
        print(f"{output}: {scene.camera.width} x {scene.camera.height}, {rays}{picture.metadata['seconds']:.2f} s; "
              f"{counts['undecided']} undecided pixels")
    return 0


def _adjusted(scene, arguments):
    """The scene with the changes that the command line asks for, under the same rules as in a scene file."""
    from pydantic import ValidationError

    from raytruth.reference_tracer.errors import InputError
    from raytruth.reference_tracer.scene.load import one_line

    try:
        if arguments.size:
            scene = scene.resized(*arguments.size)
        changes = {"samples": arguments.samples, "step_size": arguments.step_size}
        changes = {name: value for name, value in changes.items() if value is not None}
        told = _by_key("--tracing", arguments.tracing, "max_depth=1")
        changes |= {name: _json_or_text(value) for name, value in told.items()}
        scene = scene.traced_with(**changes) if changes else scene
        placed = _by_key("--camera", arguments.camera, "v_x=[1,0,0]")
        return scene.seen_by(**{name: _json_or_text(value) for name, value in placed.items()}) if placed else scene
    except ValidationError as error:
        raise InputError(f"command line: {one_line(error)}") from None


def _with_ours(scene, arguments):
    from raytruth.comparisons.progress import Progress
    from raytruth.reference_tracer.tracer.estimate import estimate
    from raytruth.reference_tracer.tracer.image_files import planes_of
    from raytruth.reference_tracer.tracer.render import Renderer

    output = Path(arguments.output)
    memory.require(scene, planes_of(output), COPIES[output.suffix.lower()], arguments.memory)
    start, method, device = time.perf_counter(), arguments.method or "exact", arguments.device or "llvm"
    with Progress(1.0, label=f"{scene.name}: compiling kernels") as bar, compile_time_announced(scene, bar):
        renderer = Renderer(scene, method, precision=arguments.precision, device=device, threads=arguments.threads)
        band = None
        if _may_be_long(scene):
            expected = estimate(renderer, lambda stage: bar.show(f"{scene.name}: {stage}"))
            band = expected.band
            if expected.seconds[1] > LONG:
                bar.log(f"raytruth: {scene.name}: {expected.sentence}")
        bar.show(scene.name)
        picture = renderer.picture(planes_of(output), progress=bar.to, band=band)
    picture.metadata["seconds"] = time.perf_counter() - start
    return picture


def _may_be_long(scene) -> bool:
    """Whether so much could have to be done that it is worth to measure before."""
    from raytruth.reference_tracer.tracer.estimate import most_rays

    paper = any(o.first_hit and o.first_hit.method == "paper" for o in scene.objects)
    steps = scene.tracing.max_distance / scene.tracing.step_size
    return most_rays(scene) > MUCH or most_rays(scene) * steps > 64 * MUCH or paper


def _by_key(option: str, items: list[str], example: str) -> dict[str, str]:
    """What an option KEY=VALUE that may be repeated sets."""
    from raytruth.reference_tracer.errors import InputError

    found = {}
    for item in items:
        key, equals, value = item.partition("=")
        if not equals:
            raise InputError(f"{option} {item}: must be KEY=VALUE, e.g. {example}")
        if key in found:
            raise InputError(f"{option} {item}: sets {key} a second time; keep one of them")
        found[key] = value
    return found


def _json_or_text(text: str):
    try:
        value = json.loads(text)
    except (ValueError, RecursionError):
        return text
    return tuple(value) if isinstance(value, list) else value


def _with_other_renderer(scene, arguments):
    from raytruth.comparisons import renderers
    from raytruth.comparisons.progress import Progress

    settings = renderers.parsed(arguments.renderer, _by_key("--set", arguments.settings, "resolution=128"))
    near = renderers.nearest(scene, arguments.renderer)
    if near.words:  # so that no other scene's picture passes for this one's
        print(f"raytruth: {scene.name}: rendered with {near.words}", file=sys.stderr)
    with Progress(1.0, label=f"{scene.name} with {arguments.renderer}"):
        picture = renderers.render(arguments.renderer, near.scene, settings)
    return picture
