"""Three reports from a few scenes, and pictures of each kind of their pages, to be looked at: with everything there, without
POV-Ray, and with a POV-Ray whose lights cast no shadows, which has to be the first thing that its report says.

  python -m tools.three_reports -o results/three

The second and third are told against the first (`raytruth report --against`). The exit code is 1 where a program can see that
something is wrong: see tools/screenshots.py.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

from raytruth.arguments import Parser, require_folder
from raytruth.reference_tracer.errors import InputError

from . import screenshots

COMPARE = ("compare", "figure-05-sphere", "figure-07-torus", "effect-shadow", "effect-reflection", "--largest", "160")
SUITES = (  # what the first report has, as small as it can be
    COMPARE,
    ("transport", "mirror", "hard-shadow"),
    ("stability", "--family", "grazing", "--rays", "100"),
    ("attribute", "--wrong-on-purpose"),
    ("chart", "figure-05-sphere", "--size", "80x60", "--turns", "1"),
    ("plan", "figure-05-sphere", "--size", "80x60"),
)
FOLDER = {"plan": "--results"}  # the option that names the folder; -o of all others
WRONG = """\
#!/bin/sh
[ "$1" = --version ] && echo "POV-Ray 3.7.0 without shadows" && exit
sed -i 's/^\\(light_source {.*\\) }$/\\1 shadowless }/' scene.pov
exec %s "$@"
"""


def raytruth(arguments: tuple[str, ...], results: Path, path: str) -> None:
    command = [sys.executable, "-m", "raytruth", *arguments, FOLDER.get(arguments[0], "-o"), str(results)]
    if subprocess.run(command, env={**os.environ, "PATH": path}, stdout=subprocess.DEVNULL).returncode not in (0, 1):
        raise InputError(f"{' '.join(command)}: did not work")


def made(folder: Path) -> list[Path]:
    """The three reports, in folders of their own below `folder`."""
    povray = shutil.which("povray")
    if povray is None:
        raise InputError("no POV-Ray on this machine: install the package povray")
    first, *others = found = [folder / name for name in ("everything", "without-povray", "wrong-povray")]
    for there in found:
        shutil.rmtree(there, ignore_errors=True)
        (there / "bin").mkdir(parents=True)
    program = others[1] / "bin" / "povray"
    program.write_text(WRONG % povray)
    program.chmod(0o755)
    usual = os.environ["PATH"]
    for suite in SUITES:
        raytruth(suite, first / "results", usual)
    raytruth(("report", "--results", str(first / "results")), first / "html", usual)
    for there, path in zip(others, (str(others[0] / "bin"), f"{others[1] / 'bin'}:{usual}")):
        shutil.copytree(first / "results", there / "results")
        raytruth(COMPARE, there / "results", path)
        raytruth(("report", "--results", str(there / "results"), "--against", str(first / "results")), there / "html", usual)
    return found


def main(arguments: list[str] | None = None) -> int:
    parser = Parser(prog="python -m tools.three_reports", description="Three reports, and pictures of each kind of page.")
    parser.add_argument("-o", "--output", type=Path, required=True, metavar="DIR", help="folder for the reports and pictures")
    folder = parser.parse_args(arguments).output
    try:
        require_folder(folder)
        found = made(folder)
    except InputError as error:
        print(f"tools.three_reports: {error}", file=sys.stderr)
        return 2
    return max(screenshots.main([str(there / "html"), "-o", str(there / "pictures")]) for there in found)


if __name__ == "__main__":
    sys.exit(main())
