"""The child process in which a renderer runs: one line of JSON in, one line of JSON out, planes through a file.

A fatal error of a renderer, which no Python code can catch, ends this process and nothing else.
"""

from __future__ import annotations

import contextlib
import json
import os
import sys
from pathlib import Path


def main() -> None:
    answers = os.fdopen(os.dup(1), "w", buffering=1)
    os.dup2(2, 1)  # whatever a renderer prints goes to stderr and cannot garble the answers
    for line in sys.stdin:
        request = json.loads(line)
        answers.write(json.dumps(_answer(request)) + "\n")


def _answer(request: dict) -> dict:
    from reference_tracer.errors import InputError, MissingError, UnsupportedError
    from reference_tracer.image_files import save_npz
    from reference_tracer.scene.load import parse_scene

    from . import renderers

    part = Path(request["planes"]).with_suffix(".part")
    try:
        scene = parse_scene(request["scene"].encode(), "scene")
        picture = renderers.render(request["renderer"], scene, request["settings"])
        save_npz(picture, part)
        os.replace(part, request["planes"])
        facts = {k: v for k, v in picture.metadata.items() if isinstance(v, (int, float, str, bool)) or v is None}
        return {"state": "ok", "facts": facts}
    except UnsupportedError as error:
        return {"state": "refused", "message": str(error)}
    except MissingError as error:
        return {"state": "missing", "message": str(error)}
    except InputError as error:
        return {"state": "crashed", "message": str(error)}
    except Exception as error:  # the case fails, the suite goes on
        return {"state": "crashed", "message": " ".join(f"{type(error).__name__}: {error}".split())[:500]}
    finally:
        with contextlib.suppress(FileNotFoundError):
            part.unlink()


if __name__ == "__main__":
    main()
