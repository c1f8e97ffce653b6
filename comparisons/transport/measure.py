"""Measures a case: both sides, the metrics, the gates."""

from __future__ import annotations

import math
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ..verdicts.metrics import VISIBLE, largest_around, pixel_error
from ..execution import store
from ..results import Gate
from . import cases, monte_carlo
from .case import Case
from .edges import document_side

P99 = 2e-5  # of deterministic cases: single precision, and what Mitsuba's offset moves on smooth parts
SLOPE, SLOPE_BAND = -0.5, 0.06
FEWEST = 0.02  # of the picture's pixels must be compared
MOST_EDGES = 0.25
NOISE_SHARE = 0.5


@dataclass(frozen=True)
class Measured:
    """Both pictures, (h, w, 3), and what was found. `compared` are the pixels on which theory speaks, (h, w)."""

    document: np.ndarray
    mitsuba: np.ndarray
    expected: np.ndarray
    compared: np.ndarray
    gates: list[Gate]
    metrics: dict[str, float | int]

    @property
    def holds(self) -> bool:
        return all(gate.holds for gate in self.gates)


def answer(arguments: dict) -> dict:
    """In a worker: measures a case by its id, and writes its pictures."""
    start, (case,) = time.monotonic(), cases.find([arguments["case"]])
    measured = measure(case)
    store.save(Path(arguments["planes"]), document=measured.document, mitsuba=measured.mitsuba, expected=measured.expected,
               compared=measured.compared)
    return {"state": "ok", "facts": {"gates": [gate.model_dump() for gate in measured.gates], "metrics": measured.metrics,
                                     "seconds": round(time.monotonic() - start, 2)}}


def measure(case: Case) -> Measured:
    """Renders both sides of `case` and judges them."""
    picture, allowance = document_side(case.scene)
    expected = picture.color if case.predicted is None else case.predicted(picture)
    compared = np.ones(allowance.shape, bool) if case.where is None else case.where(picture)
    smooth = compared & np.isfinite(allowance)
    pixels, edges = int(compared.sum()), int((compared & ~smooth).sum())
    coverage = [
        _gate("pixels compared", pixels, max(1, round(FEWEST * compared.size)), "pixels",
              "pixels on which theory speaks", at_least=True),
        _gate("edge pixels", edges, round(MOST_EDGES * pixels), "pixels",
              "pixels that Mitsuba's offset of ray origins may change visibly")]
    if not smooth.any():
        return Measured(picture.color, np.full_like(expected, np.nan), expected, compared, coverage, {})
    if case.ladder:
        seen, gates, metrics = _monte_carlo(case, expected, allowance, smooth)
    else:
        seen, gates, metrics = _deterministic(case, expected, compared, smooth)
    difference = pixel_error(picture.color, seen.mean)[compared]
    metrics |= {"pixels": int(compared.size), "pixels compared": pixels, "edge pixels": edges,
                "mean difference from the document": float(difference.mean()),
                "largest difference from the document": float(difference.max())}
    return Measured(picture.color, seen.mean, expected, compared, gates + coverage, metrics)


def _deterministic(case: Case, expected, compared, smooth):
    seen = case.mitsuba(case.scene, 1, 0)
    error = pixel_error(expected, seen.mean)
    lost = int((compared & np.isnan(error)).sum())
    error = np.where(np.isnan(error), np.inf, error)
    failing = error > VISIBLE
    gates = [
        _gate("not finite", lost, 0, "pixels", "pixels whose colour is NaN or infinite"),
        _gate("color p99", float(np.quantile(error[compared], 0.99)), P99, "linear",
              "99 % of the compared pixels have a smaller error"),
        _gate("failing pixels", int((failing & smooth).sum()), 0, "pixels",
              "pixels off by more than one step of an 8-bit picture, away from edges")]
    metrics = {"color mean": float(error[compared].mean()), "color max": float(error[compared].max()),
               "failing edge pixels": int((failing & compared & ~smooth).sum())}
    return seen, gates, metrics


def _monte_carlo(case: Case, expected, allowance, smooth):
    runs = {samples: case.mitsuba(case.scene, samples, seed) for seed, samples in enumerate(case.ladder)}
    seen = runs[max(runs)]
    branches = largest_around(seen.variance.max(axis=-1)) > 0  # a neighbour may have met what a pixel has not
    # where noise outweighs what the offset may do
    noisy = smooth & (allowance < NOISE_SHARE * np.sqrt(seen.variance.max(axis=-1)))
    rms = lambda values: float(np.sqrt(np.mean(values[noisy] ** 2))) if noisy.any() else math.nan
    errors = {n: rms(run.mean - expected) for n, run in runs.items()}
    allowed = np.where(np.isfinite(allowance), allowance, 0)
    scores = monte_carlo.scores(seen, expected, allowed, branches)
    z = scores[smooth]
    lost = int((~np.isfinite(seen.mean[smooth])).sum())
    found = monte_carlo.slope(errors)
    gates = [
        _gate("not finite", lost, 0, "values", "values that are NaN or infinite"),
        _gate("largest z", float(np.abs(z).max()), monte_carlo.limit(z.size), "deviations",
              f"the largest deviation of {z.size} values in units of their own noise; the limit is Sidak's at 1 %"),
        _gate("slope", abs(found - SLOPE), SLOPE_BAND, "exponent",
              f"how far the error's exponent is from -1/2: it falls with the {found:.3f}th power of the samples")]
    metrics = {"slope": found, "noisy pixels": int(noisy.sum()), "mean z squared of noisy pixels": rms(scores) ** 2,
               **{f"rms error at {samples} samples": error for samples, error in errors.items()}}
    return seen, gates, metrics


def _gate(name: str, value, limit: float, unit: str, means: str, at_least: bool = False) -> Gate:
    holds = value is not None and (value >= limit if at_least else value <= limit)  # NaN breaks every gate
    return Gate(name=name, value=value, limit=limit, holds=bool(holds), unit=unit, means=means)
