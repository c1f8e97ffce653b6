"""One random scene rendered and judged, in a worker of the pool."""

from __future__ import annotations

import json
from random import Random

JUDGED = 16  # pixels of a picture, drawn at random


def answer(arguments: dict) -> dict:
    """What a worker answers to a task."""
    return {"state": "ok", "facts": judged(**arguments)}


def judged(seed: int, method: str) -> dict:
    """One scene rendered and judged, as the fields of suite.Answer."""
    from raytruth.reference_tracer.errors import InputError
    from raytruth.reference_tracer.scene.load import parse_scene
    from raytruth.reference_tracer.tracer.render import render

    from .grammar import draw
    from .judge import Judge

    drawn = draw(seed)
    answer = {"seed": seed, "kind": drawn.kind, "traits": sorted(drawn.traits)}
    try:
        # of every other seed formulas are compiled whatever the size, so that both ways are judged
        interpret = False if seed % 2 else None
        picture = render(parse_scene(json.dumps(drawn.scene).encode()), method, threads=1, interpret=interpret)
    except InputError as error:
        return {**answer, "fault": f"refused: {error}"}
    except Exception as error:
        return {**answer, "fault": f"{type(error).__name__}: {error}"[:300]}
    height, width = picture.index.shape
    pixels = [(row, column) for row in range(height) for column in range(width)]
    judge = Judge(drawn.scene, seed)
    hold = judge.judge_literal if method == "paper" else judge.judge
    found = hold(picture, Random(seed).sample(pixels, min(JUDGED, len(pixels))))
    return {**answer,
            "wrong": [f"row {w.row}, column {w.column}: {w.what}: {w.text}" for w in found.wrong],
            "counts": {"pixels": found.pixels, "hits": found.hits, "undecided_hits": found.undecided_hits,
                       "avoidable_hits": found.avoidable_hits, "rounding": found.rounding,
                       "unsettled": sum(found.unsettled.values())}}
