"""The child process in which cases are measured: one fatal kernel costs one case."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np

from ..worker import serve


def main() -> None:
    serve(_answer)


def _answer(request: dict) -> dict:
    from . import cases
    from .measure import measure

    case, = cases.find([request["case"]])
    measured = measure(case)
    planes = Path(request["planes"])
    part = planes.with_suffix(".part")
    with part.open("wb") as file:
        np.savez_compressed(file, document=measured.document, mitsuba=measured.mitsuba, expected=measured.expected,
                            compared=measured.compared)
    os.replace(part, planes)
    gates = [gate.model_dump() for gate in measured.gates]
    return {"state": "ok", "facts": {"gates": gates, "metrics": measured.metrics}}


if __name__ == "__main__":
    main()
