"""Programs that stand in the place of a pool's worker: with renderers that misbehave, or with a fault of their own."""

import signal
import sys
import textwrap
from pathlib import Path

MISBEHAVING = (sys.executable, str(Path(__file__).with_name("misbehaving.py")))


def child(body: str) -> tuple[str, ...]:
    """A worker that runs `body` for each `line` of its input, with `request` and its `arguments`."""
    program = ("import json, os, signal, sys, time\nimport numpy as np\nfor line in sys.stdin:\n"
               "    request = json.loads(line)\n    arguments = request.get('arguments') if isinstance(request, dict) else None\n")
    return sys.executable, "-u", "-c", program + textwrap.indent(textwrap.dedent(body), "    ")


def interruptible() -> None:
    """For a child that is to be interrupted: where SIGINT is ignored (nohup, a background job) it would inherit that."""
    signal.signal(signal.SIGINT, signal.default_int_handler)


def exit_code(*arguments: str) -> int:
    """Of the command line, whoever finds the fault: the parser exits where a command returns."""
    from raytruth.cli import main

    try:
        return main(list(arguments))
    except SystemExit as stop:
        return stop.code
