"""The command line."""

from __future__ import annotations

import argparse
import sys


def main(argv=None) -> int:
    parser = argparse.ArgumentParser(prog="raytruth")
    commands = parser.add_subparsers(dest="command", required=True)
    render = commands.add_parser("render")
    render.add_argument("scene")
    render.add_argument("-o", "--output", required=True)
    render.add_argument("--method", default="exact")
    render.add_argument("--width", type=int)
    arguments = parser.parse_args(argv)
    from reference_tracer.errors import InputError
    try:
        from reference_tracer.image_files import save
        from reference_tracer.render import render as render_scene
        from reference_tracer.scene.library import find
        scene = find(arguments.scene)
        if arguments.width:
            scene = scene.resized(arguments.width, round(arguments.width * scene.camera.height / scene.camera.width))
        picture = render_scene(scene, arguments.method)
        save(picture, arguments.output)
        print({k: v for k, v in picture.metadata.items()}, "undecided", int((picture.status == 2).sum()))
    except InputError as error:
        print(f"raytruth: {error}", file=sys.stderr)
        return 2
    return 0
