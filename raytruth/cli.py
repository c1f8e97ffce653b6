"""The command line: one module of `raytruth.commands` a command."""

from __future__ import annotations

import argparse
import os
import sys
from importlib import import_module

COMMANDS = ("scenes", "render", "compare", "attribute", "report", "certify", "sensitivity", "stability",
            "transport", "chart", "plan", "doctor")
OK, FINDINGS, BAD_INPUT = 0, 1, 2

EPILOG = """\
first steps:
  raytruth doctor                                   is everything there?
  raytruth scenes                                   the scenes that come with raytruth
  raytruth render figure-05-sphere -o sphere.png    a picture
  raytruth compare && raytruth report               everything against everything, as HTML

exit codes: 0 all is well, 1 something differs, failed or is missing, 2 the input cannot be used
"""


def main(argv: list[str] | None = None) -> int:
    """Runs one command and returns the process's exit code."""
    parser = argparse.ArgumentParser(prog="raytruth", epilog=EPILOG, formatter_class=argparse.RawDescriptionHelpFormatter,
                                     description="The ground truth for ray tracers of implicit surfaces f(x, y, z) = 0.")
    commands = parser.add_subparsers(dest="command", required=True, metavar="COMMAND")
    modules = {}
    for name in COMMANDS:
        module = modules[name] = import_module(f"raytruth.commands.{name}")
        summary = module.__doc__.splitlines()[0]
        own = commands.add_parser(name, help=summary[0].lower() + summary[1:].rstrip("."), description=module.__doc__,
                                  formatter_class=argparse.RawDescriptionHelpFormatter)
        module.add_arguments(own)
    arguments = parser.parse_args(argv)
    from reference_tracer.errors import InputError

    try:
        return modules[arguments.command].run(arguments)
    except InputError as error:
        print(f"raytruth: {error}", file=sys.stderr)
        return BAD_INPUT
    except KeyboardInterrupt:
        print("raytruth: interrupted; finished work is kept", file=sys.stderr)
        return 130
    except BrokenPipeError:  # the reader of our output has gone
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return OK
