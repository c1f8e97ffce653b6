"""The child process in which a renderer runs: one line of JSON in, one line of JSON out, pictures through files.

A fatal error of a renderer, which no Python code can catch, ends this process and nothing else.
"""

from __future__ import annotations

import contextlib
import json
import os
import resource
import signal
import sys
import threading
import time
from collections.abc import Callable
from pathlib import Path

LARGEST_FILE = 1 << 30, 256  # bytes a renderer may write into one file, and as many more a pixel


def main() -> None:
    serve(_answer)


def serve(answer: Callable[[dict], dict]) -> None:
    """Answers requests until there are none: with what `answer` returns, or with why it could not."""
    answers = os.fdopen(os.dup(1), "w", buffering=1)
    os.dup2(2, 1)  # whatever a renderer prints goes to stderr and cannot garble the answers
    signal.signal(signal.SIGXFSZ, signal.SIG_IGN)  # a file too large is an error of the write, not the end
    threading.Thread(target=_end_with, args=(os.getppid(),), daemon=True).start()
    for line in sys.stdin:
        answers.write(json.dumps(_guarded(answer, json.loads(line))) + "\n")


def _end_with(parent: int) -> None:
    """Ends this process group when the process that asks is gone: nobody else would."""
    while os.getppid() == parent:
        time.sleep(1)
    if os.getpgrp() == os.getpid():
        os.killpg(0, signal.SIGKILL)
    os._exit(1)


def _guarded(answer: Callable[[dict], dict], request: dict) -> dict:
    from reference_tracer.errors import InputError, MissingError, UnsupportedError

    try:
        return answer(request)
    except UnsupportedError as error:
        return {"state": "refused", "message": str(error)}
    except MissingError as error:
        return {"state": "missing", "message": str(error)}
    except InputError as error:
        return {"state": "crashed", "message": str(error)}
    except Exception as error:  # the case fails, the suite goes on
        return {"state": "crashed", "message": " ".join(f"{type(error).__name__}: {error}".split())[:500]}


def _answer(request: dict) -> dict:
    from reference_tracer.image_files import save_npz
    from reference_tracer.scene.load import parse_scene

    from . import renderers

    part = Path(request["planes"]).with_suffix(".part")
    try:
        scene = parse_scene(request["scene"].encode(), "scene")
        most = LARGEST_FILE[0] + LARGEST_FILE[1] * scene.camera.width * scene.camera.height
        resource.setrlimit(resource.RLIMIT_FSIZE, (most, resource.getrlimit(resource.RLIMIT_FSIZE)[1]))
        picture = renderers.render(request["renderer"], scene, request["settings"])
        save_npz(picture, part)
        os.replace(part, request["planes"])
        facts = {k: v for k, v in picture.metadata.items() if isinstance(v, (int, float, str, bool)) or v is None}
        return {"state": "ok", "facts": facts}
    finally:
        with contextlib.suppress(FileNotFoundError):
            part.unlink()


if __name__ == "__main__":
    main()
