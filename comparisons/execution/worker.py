"""The child process in which cases are made: one line of JSON in, one line of JSON out, arrays through files.

A request names a function, "module:function", its arguments, a dict, and the id of the process that asks; the function
answers with a dict that holds at least {"state": "ok"}. A fatal error of a renderer, which no Python code can catch, ends
this process and nothing else.
"""

from __future__ import annotations

import json
import os
import signal
import sys
import threading
import time
from importlib import import_module

_answers = None  # the stream of answers; None in a process that serves nobody


def main() -> None:
    """Answers requests until there are none: with what their functions return, or with why they could not."""
    global _answers
    _answers = os.fdopen(os.dup(1), "w", buffering=1)
    os.dup2(2, 1)  # whatever a renderer prints goes to stderr and cannot garble the answers
    signal.signal(signal.SIGXFSZ, signal.SIG_IGN)  # a file too large is an error of the write, not the end
    threading.Thread(target=_end_with, args=(os.getppid(),), daemon=True).start()
    for line in sys.stdin:
        request = json.loads(line)
        if request["asker"] != os.getppid():  # gone before this process could know it: `_end_with` waits for another one
            return
        _answers.write(json.dumps(answer(request)) + "\n")


def tell(label: str, share: float) -> None:
    """Says how far the case is that is being made, for whoever waits for it; silent in a process that serves nobody."""
    if _answers is not None:
        _answers.write(json.dumps({"share": share, "label": label}) + "\n")


def answer(request: dict) -> dict:
    """What the function that `request` names returns, or what became of it."""
    from raytruth.reference_tracer.errors import InputError, MissingError, UnsupportedError

    from .store import UnwritableError

    try:
        module, _, name = request["function"].partition(":")
        return getattr(import_module(module), name)(request["arguments"])
    except UnsupportedError as error:
        return {"state": "refused", "message": str(error)}
    except MissingError as error:
        return {"state": "missing", "message": str(error)}
    except UnwritableError as error:
        return {"state": "unwritable", "message": str(error)}
    except InputError as error:
        return {"state": "crashed", "message": str(error)}
    except Exception as error:  # the case fails, the suite goes on
        return {"state": "crashed", "message": " ".join(f"{type(error).__name__}: {error}".split())[:500]}


def _end_with(parent: int) -> None:
    """Ends this process group when the process that asks is gone: nobody else would."""
    while os.getppid() == parent:
        time.sleep(1)
    if os.getpgrp() == os.getpid():
        os.killpg(0, signal.SIGKILL)
    os._exit(1)


if __name__ == "__main__":
    from raytruth.comparisons.execution import worker  # the module that others import, not a second one called __main__

    worker.main()
