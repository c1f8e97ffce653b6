"""Render a scene to a PNG, EXR or NPZ file.

examples:
  raytruth render figure-05-sphere -o sphere.png
  raytruth render my-scene.json -o out.exr --method paper --step-size 0.05
  raytruth render figure-17-scene1 -o out.png --size 640x480 --samples 4
  raytruth render figure-07-torus -o torus.npz --with mitsuba-mesh --set resolution=128

PNG holds the 8-bit picture; EXR all planes (colour, depth, position, normal, object, status) as floats; NPZ all
planes in full double precision.
"""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path


def add_arguments(parser):
    parser.add_argument("scene", help="name of a shipped scene or path of a scene file")
    parser.add_argument("-o", "--output", required=True, metavar="FILE", help="ends in .png, .exr or .npz")
    parser.add_argument("--method", default="exact", help="first-hit method: exact (default), paper, descartes, interval, proof")
    parser.add_argument("--with", dest="renderer", metavar="RENDERER",
                        help="another renderer: mitsuba-native or mitsuba-mesh")
    parser.add_argument("--set", dest="settings", action="append", default=[], metavar="KEY=VALUE",
                        help="a setting of that renderer, e.g. resolution=128")
    parser.add_argument("--size", metavar="WxH", type=size, help="picture size instead of the scene's")
    parser.add_argument("--samples", type=int, metavar="N", help="N x N samples a pixel instead of the scene's")
    parser.add_argument("--step-size", type=float, metavar="H", help="step size instead of the scene's")
    parser.add_argument("--precision", type=int, choices=(64, 32), help="bits of the floats (default: the scene's, 64)")
    parser.add_argument("--device", choices=("llvm", "cuda"), default="llvm", help="processor (default) or graphics card")
    parser.add_argument("--threads", type=int, metavar="N", help="threads to use (default: all cores)")
    parser.add_argument("--json", action="store_true", help="print what was made as JSON")


def size(text: str) -> tuple[int, int]:
    width, _, height = text.partition("x")
    if not (width.isascii() and width.isdigit() and height.isascii() and height.isdigit()):
        raise argparse.ArgumentTypeError(f"{text!r} is not WIDTHxHEIGHT, e.g. 640x480")
    return int(width), int(height)


def run(arguments) -> int:
    from reference_tracer.image_files import require_writable, save
    from reference_tracer.scene.library import find

    output = Path(arguments.output)
    require_writable(output)  # before the work, not after it
    scene = _adjusted(find(arguments.scene), arguments)
    picture = _with_other_renderer(scene, arguments) if arguments.renderer else _with_ours(scene, arguments)
    save(picture, output)
    counts = {name: int((picture.status == code).sum()) for name, code in (("miss", 0), ("hit", 1), ("undecided", 2))}
    if arguments.json:
        print(json.dumps({"file": str(output), "pixels": counts, **picture.metadata}))
    else:
        print(f"{output}: {scene.camera.width} x {scene.camera.height}, {picture.metadata.get('rays', 0):,} rays in "
              f"{picture.metadata['seconds']:.2f} s; {counts['undecided']} undecided pixels")
    return 0


def _adjusted(scene, arguments):
    """The scene with the changes that the command line asks for, under the same rules as in a scene file."""
    from pydantic import ValidationError

    from reference_tracer.errors import InputError
    from reference_tracer.scene.load import one_line

    try:
        if arguments.size:
            scene = scene.resized(*arguments.size)
        changes = {"samples": arguments.samples, "step_size": arguments.step_size}
        changes = {name: value for name, value in changes.items() if value is not None}
        return scene.traced_with(**changes) if changes else scene
    except ValidationError as error:
        raise InputError(f"command line: {one_line(error)}") from None


def _with_ours(scene, arguments):
    from reference_tracer.image_files import planes_of
    from reference_tracer.render import render

    bar = _bar(scene)
    picture = render(scene, arguments.method, precision=arguments.precision, device=arguments.device,
                     threads=arguments.threads, planes=planes_of(Path(arguments.output)), progress=bar.to if bar else None)
    if bar:
        bar.close()
    return picture


def _bar(scene):
    if not sys.stderr.isatty():
        return None
    from comparisons.progress import Progress

    return Progress(1.0, label=scene.name)


def _with_other_renderer(scene, arguments):
    from comparisons import renderers
    from reference_tracer.errors import InputError

    settings = {}
    for item in arguments.settings:
        key, equals, value = item.partition("=")
        if not equals:
            raise InputError(f"--set {item}: must be KEY=VALUE, e.g. resolution=128")
        try:
            settings[key] = json.loads(value)
        except ValueError:
            settings[key] = value
    return renderers.render(arguments.renderer, scene, settings)
