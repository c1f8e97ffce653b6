"""The command line: one module of `raytruth.commands` a command."""

from __future__ import annotations

import argparse
import contextlib
import os
import signal
import sys
import threading
from importlib import import_module

import shtab

from .arguments import Parser, sentence

COMMANDS = ("scenes", "render", "export", "check-image", "check-port", "truth", "compare", "attribute", "report", "certify",
            "sensitivity", "stability", "transport", "chart", "plan", "bench", "doctor")
KEEPING = ("compare", "attribute", "transport", "chart")  # those whose next run reuses what an interrupted one finished
OK, FINDINGS, BAD_INPUT, INTERRUPTED = 0, 1, 2, 130

EPILOG = """\
first steps:
  raytruth doctor                                   is everything there?
  raytruth scenes                                   the scenes that come with raytruth
  raytruth render figure-05-sphere -o sphere.png    a picture
  raytruth compare && raytruth report               everything against everything, as HTML

exit codes: 0 all is well, 1 something differs, failed or is missing, 2 the input cannot be used, 130 interrupted
"""
PATIENCE = 1.0  # seconds that work may take to end after Ctrl-C; a kernel that is being compiled or run hears nothing


def main(argv: list[str] | None = None) -> int:
    """Runs one command and returns the process's exit code."""
    parser = Parser(prog="raytruth", epilog=EPILOG, formatter_class=argparse.RawDescriptionHelpFormatter,
                                     description="The ground truth for ray tracers of implicit surfaces f(x, y, z) = 0.")
    shtab.add_argument_to(parser, "--print-completion", help="print a script that completes commands and options, for a shell")
    commands = parser.add_subparsers(dest="command", required=True, metavar="COMMAND")
    modules = {}
    for name in COMMANDS:
        module = modules[name] = import_module(f"raytruth.commands.{name.replace('-', '_')}")
        summary = module.__doc__.splitlines()[0]
        own = commands.add_parser(name, help=summary[0].lower() + summary[1:].rstrip("."), description=module.__doc__,
                                  formatter_class=argparse.RawDescriptionHelpFormatter)
        module.add_arguments(own)
    if any("\0" in argument for argument in argv or ()):  # no shell can pass one, a program can
        parser.error("an option or path holds the character NUL; leave it out")
    if wrong := [a for a in (sys.argv[1:] if argv is None else argv) if a.startswith("--") and a.endswith("=--")]:
        parser.error(f"{wrong[0]}: is an option without a value")  # argparse makes a list of what is after the sign
    try:
        arguments = parser.parse_args(argv)  # it prints, where help is asked for
        sys.stdout.flush()
    except BrokenPipeError:
        return _unheard()
    from raytruth.reference_tracer.errors import InputError

    goodbye = "raytruth: interrupted" + ("; finished runs are kept" if arguments.command in KEEPING else "")
    with _interruptible(goodbye):
        try:
            return modules[arguments.command].run(arguments)
        except InputError as error:
            print(f"raytruth: {sentence(error)}", file=sys.stderr)
            return BAD_INPUT
        except BrokenPipeError:
            return _unheard()
        except OSError as error:  # a disk that is full, a folder that may not be written
            what = f"{error.filename}: cannot be used" if error.filename else "the system refuses"
            print(f"raytruth: {sentence(f'{what} ({error.strerror or error})')}; choose another file or folder, or make room",
                  file=sys.stderr)
            return BAD_INPUT
        except MemoryError:
            print("raytruth: there is too little memory for this; make the picture or the scene smaller", file=sys.stderr)
            return BAD_INPUT
        except BaseException as error:
            if not _is_interruption(error):
                raise
            print(goodbye, file=sys.stderr)
            return INTERRUPTED


def _unheard() -> int:
    """The reader of our output has gone: what is left of it goes nowhere."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    return OK


def _is_interruption(error: BaseException | None) -> bool:
    """Whether Ctrl-C is the error or its cause: Dr.Jit raises an error of its own where it meets one while it records."""
    while error and not isinstance(error, KeyboardInterrupt):
        error = error.__cause__ or error.__context__
    return error is not None


@contextlib.contextmanager
def _interruptible(goodbye: str):
    """Ctrl-C ends the process soon, also while a kernel runs or is compiled, where Python does not hear of it."""
    if (threading.current_thread() is not threading.main_thread()
            or signal.getsignal(signal.SIGINT) is not signal.default_int_handler):
        yield
        return
    listens, tells = os.pipe()
    os.set_blocking(tells, False)
    ended = threading.Event()

    def watch():
        while (numbers := os.read(listens, 1)) and numbers[0] != signal.SIGINT:
            pass
        if numbers and not ended.wait(PATIENCE):
            shown = "\x1b[?25h\n" if sys.stderr.isatty() else ""  # a progress bar hides the cursor
            os.write(2, f"{shown}{goodbye}\n".encode())
            os._exit(INTERRUPTED)

    before = signal.set_wakeup_fd(tells, warn_on_full_buffer=False)
    watcher = threading.Thread(target=watch, daemon=True, name="interrupts")
    watcher.start()
    try:
        yield
    finally:
        ended.set()
        signal.set_wakeup_fd(before)
        os.close(tells)
        watcher.join()
        os.close(listens)
