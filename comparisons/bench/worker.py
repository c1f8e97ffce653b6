"""The child process that measures: a case asked for, its rows answered."""

from __future__ import annotations

from ..worker import serve
from . import groups
from .options import Options


def _answer(request: dict) -> dict:
    rows = groups.GROUPS[request["group"]].measure(request["case"], Options(**request["options"]))
    return {"state": "ok", "rows": [row.model_dump(mode="json") for row in rows]}


if __name__ == "__main__":
    serve(_answer)
