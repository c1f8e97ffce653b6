"""Runs action.yml as GitHub would, on this machine: its shell steps, one after another, in a folder of their own.

  python -m tools.action "./tracer --serve" --options "--only algorithm:surfaces" --known-failures known.json

What `uses` names is left out: the Python that runs this takes the place of what actions/setup-python installs. The exit code
is that of the first step that fails; what steps write to GITHUB_OUTPUT is printed.
"""

from __future__ import annotations

import os
import re
import subprocess
import sys
import tempfile
from collections.abc import Mapping
from pathlib import Path

import yaml

from raytruth.arguments import Parser

ACTION = Path(__file__).parents[1] / "action.yml"


def run(given: Mapping[str, str], temp: Path, steps: slice = slice(None),
        folder: Path | None = None) -> tuple[int, dict[str, str]]:
    """The exit code and the outputs of the action with these inputs; `temp` is the runner's, `folder` the user's checkout."""
    action, output = yaml.safe_load(ACTION.read_text(encoding="utf-8")), temp / "output"
    inputs = {name: given.get(name, str(about.get("default", ""))) for name, about in action["inputs"].items()}
    if lacking := [name for name, about in action["inputs"].items() if about.get("required") and name not in given]:
        raise ValueError(f"inputs that are needed: {', '.join(lacking)}")
    filled = lambda text: re.sub(r"\$\{\{ *inputs\.([a-z-]+) *\}\}", lambda m: inputs[m[1]], text)
    output.write_text("")
    fixed = {"GITHUB_ACTION_PATH": str(ACTION.parent), "RUNNER_TEMP": str(temp), "GITHUB_OUTPUT": str(output),
             "PATH": f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"}
    for step in [step for step in action["runs"]["steps"] if "run" in step][steps]:
        environment = {**os.environ, **fixed, **{name: filled(str(text)) for name, text in step.get("env", {}).items()}}
        # as GitHub starts `shell: bash`
        done = subprocess.run(["bash", "--noprofile", "--norc", "-eo", "pipefail", "-c", filled(step["run"])], env=environment,
                              cwd=folder)
        if done.returncode:
            break
    told = dict(line.split("=", 1) for line in output.read_text().splitlines())
    return done.returncode, told


def main(arguments: list[str] | None = None) -> int:
    parser = Parser(prog="python -m tools.action", description="Runs action.yml on this machine.")
    parser.add_argument("port", help="the input of that name")
    for name in ("options", "known-failures"):
        parser.add_argument(f"--{name}", default="", help="the input of that name")
    chosen = parser.parse_args(arguments)
    with tempfile.TemporaryDirectory(prefix="raytruth-") as temp:
        code, told = run({"port": chosen.port, "options": chosen.options, "known-failures": chosen.known_failures}, Path(temp))
    for name, value in told.items():
        print(f"{name}={value}")
    return code


if __name__ == "__main__":
    sys.exit(main())
