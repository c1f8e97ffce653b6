"""The published figures: how near the shipped scenes come, and fits of scenes to pictures. Pictures stay outside.

  python -m tools.figures match FOLDER -o reports/published.json     all figures; exit code 1 where a bar is missed
  python -m tools.figures match FOLDER figure-05-sphere --pixels 20000
  python -m tools.figures fit PICTURE figure-05-sphere@published --free lights[0].position,camera.fov -o fitted.json
"""

from __future__ import annotations

import argparse
import datetime
import json
import sys
from pathlib import Path

from raytruth.arguments import Parser, require_file, whole
from raytruth.reference_tracer.errors import InputError
from raytruth.reference_tracer.scene import library


def main(arguments: list[str] | None = None) -> int:
    parser = Parser(prog="python -m tools.figures", description=__doc__,
                    formatter_class=argparse.RawDescriptionHelpFormatter)
    commands = parser.add_subparsers(dest="command", required=True)
    matching = commands.add_parser("match", help="compare the shipped scenes with a folder of published figures")
    matching.add_argument("folder", type=Path)
    matching.add_argument("scene", nargs="*", help="names of shipped scenes (default: all of the document)")
    matching.add_argument("--pixels", type=whole(1), metavar="N",
                          help="at most N pixels of each, chosen at random (default: all)")
    matching.add_argument("-o", "--output", type=Path, metavar="FILE", help="write the numbers as JSON; those of figures not "
                          "compared now are kept")
    fitting = commands.add_parser("fit", help="fit numbers of a scene to a picture by least squares")
    fitting.add_argument("picture", type=Path)
    fitting.add_argument("scene", help="a scene file or a shipped scene; SCENE@published for its figure's form")
    fitting.add_argument("--free", required=True, metavar="PATH,...", help="e.g. camera.fov,lights[0].position; A=B ties two")
    fitting.add_argument("--pixels", type=whole(1), default=3000, metavar="N", help="to compare (default: %(default)s)")
    fitting.add_argument("-o", "--output", type=Path, metavar="FILE", help="write the fitted scene as JSON")
    chosen = parser.parse_args(arguments)
    try:
        require_file(chosen.output, ".json")
        return {"match": _match, "fit": _fit}[chosen.command](chosen)
    except InputError as error:
        print(f"tools.figures: {error}", file=sys.stderr)
        return 2


def _match(chosen) -> int:
    from .match import figure_file, match
    from .pixels import read_picture

    command = " ".join(["python -m tools.figures match FOLDER", *([f"--pixels {chosen.pixels}"] if chosen.pixels else [])])
    known = json.loads(chosen.output.read_text(encoding="utf-8")) if chosen.output and chosen.output.exists() else {}
    missed = 0
    for name in chosen.scene or library.names():
        scene = library.scene(name)
        found = match(scene, read_picture(figure_file(chosen.folder, scene)), chosen.pixels)
        shown, left, counts = found["figure_form"]["within_1"], found["left"], lambda of: ", ".join(of) or "nothing"
        # figure 9's bar is meant outside the belt's specks
        missed += shown + 100 * left.get("belt of the heart", 0) / found["pixels"] < found["bar"]
        print(f"{name}: figure's form {shown:.3f} % (bar {found['bar']} %), text's form "
              f"{found['text_form']['within_1']:.2f} %; changed by "
              + counts(f"{s['id']} {s['in_turn']:.2f} %" for s in found["switches"])
              + "; left: " + counts(f"{count} {kind}" for kind, count in left.items()), flush=True)
        known[name] = {"date": datetime.date.today().isoformat(), "command": command, **found}
        if chosen.output:
            text = json.dumps(dict(sorted(known.items())), indent=1)
            chosen.output.write_text(text + "\n", encoding="utf-8")
    return 1 if missed else 0


def _fit(chosen) -> int:
    from .fit import fit
    from .pixels import read_picture

    found = fit(library.find(chosen.scene), read_picture(chosen.picture), chosen.free.split(","), chosen.pixels,
                lambda line: print(line, flush=True))
    for name, value, error in zip(found.names, found.values, found.errors):
        print(f"{name:40} {value:12.6g} +- {error:.2g}")
    print(f"{found.pixels} pixels off edges: median {found.median:.3f}, rms {found.rms:.3f} grey levels")
    if chosen.output:
        text = found.scene.model_dump_json(indent=1, by_alias=True, exclude_none=True)
        chosen.output.write_text(text + "\n", encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
