"""The rays of one pixel, or of one given ray, as the reference traces them, beside what a port says of the first."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from raytruth.reference_tracer.errors import InputError

from ..attribution.document import History
from ..attribution.rays import name_of
from ..attribution.rays import ours as followed
from .cases import Case
from .check import question
from .session import Failure, Port
from .truth import renderer


def ours(case: Case, pixel: int) -> History:
    """The rays of a pixel, or of a given ray, counted in row order from 0."""
    tracer = renderer(case)
    return followed(tracer, [divmod(pixel, tracer.scene.camera.width)], "reference")[0]


def beside(port: Port, case: Case, place: str, seconds: float) -> Iterator[str]:
    """Lines for a person. Raises InputError."""
    where = _where(case, place)
    pixel = int(np.ravel_multi_index(where, question(case).shape))
    answer = port.answer(question(case), seconds)
    vector = lambda v: f"({', '.join(f'{c:.12g}' for c in v)})" if v is not None else "-"
    yield f"{case.id}, {'pixel' if case.rays is None else 'ray'} {place}"
    for ray in ours(case, pixel).rays:
        share = f", weight {ray.weight:.4g}" if ray.weight is not None else ""
        yield f"  reference: {ray.generation} {ray.kind}{share}: " + (
            f"{ray.object} at t = {ray.t:.17g}" if ray.object else "nothing")
        if ray.object:
            yield f"      normal {vector(ray.normal)}, {ray.lights} lights, own colour {vector(ray.color)}"
    if isinstance(answer, Failure) or answer.unsupported is not None:
        yield f"  the port: {answer.message if isinstance(answer, Failure) else answer.unsupported}"
        return
    told = {name: array[where] for name, array in answer.arrays.items()}
    if "index" in told:
        met = name_of(case.scene, int(told["index"])) if told["index"] >= 0 else "nothing"
        yield f"  the port: 0 camera: {met}" + (f" at t = {told['t']:.17g}" if "t" in told and told["index"] >= 0 else "")
    if "normal" in told:
        yield f"      normal {vector(told['normal'])}"
    yield f"      colour of all {vector(told['color'])}"


def _where(case: Case, place: str) -> tuple[int, ...]:
    shape, parts = question(case).shape, place.split(",")
    if len(parts) != len(shape) or not all(p.isascii() and p.isdigit() and len(p) < 7 for p in parts):
        raise InputError("--history: must be ROW,COL of a picture, or the number of a ray")
    where = tuple(map(int, parts))
    if any(k >= n for k, n in zip(where, shape)):
        raise InputError(f"--history: {place} lies beyond {' x '.join(map(str, shape))}")
    return where
