"""The child process that measures: one case asked for in a line of JSON, its rows answered in one."""

from __future__ import annotations

import json
import os
import sys

from reference_tracer.errors import InputError, MissingError, UnsupportedError

from . import groups
from .options import Options


def main() -> None:
    answers = os.fdopen(os.dup(1), "w", buffering=1)
    os.dup2(2, 1)  # what a renderer prints goes to stderr and cannot garble the answers
    for line in sys.stdin:
        answers.write(json.dumps(_answer(json.loads(line))) + "\n")


def _answer(request: dict) -> dict:
    try:
        rows = groups.GROUPS[request["group"]].measure(request["case"], Options(**request["options"]))
        return {"state": "ok", "rows": [row.model_dump(mode="json") for row in rows]}
    except UnsupportedError as error:
        return {"state": "refused", "message": str(error)}
    except MissingError as error:
        return {"state": "missing", "message": str(error)}
    except Exception as error:  # the case fails, the benchmark goes on
        name = "" if isinstance(error, InputError) else f"{type(error).__name__}: "
        return {"state": "crashed", "message": " ".join(f"{name}{error}".split())[:500]}


if __name__ == "__main__":
    main()
