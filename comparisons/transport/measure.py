"""Measures cases in workers: both pictures, the metrics, the gates. What is finished is kept by its content.

A Monte Carlo case is judged by whether the difference of every pixel's mean from its expectation is what its own noise
allows, and by how its error falls.
"""

from __future__ import annotations

import math
import time
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from statistics import NormalDist

import numpy as np
from pydantic import ValidationError

from raytruth.converters.mitsuba.radiance import Radiance
from raytruth.reference_tracer.scene.model import Scene
from raytruth.reference_tracer.tracer.render import UNDECIDED, Picture
from raytruth.reference_tracer.tracer.sensitivity import ORIGIN_UNITS, SAFETY, perturbed

from ..execution import store
from ..execution.cluster import engine
from ..execution.pool import Progress, Task, complete
from ..execution.store import Store
from ..results import Gate
from ..suites import head
from ..verdicts.metrics import VISIBLE, largest_around, pixel_error
from .cases import Case, find
from .document import FOLDER, CaseRecord, Transport

P99 = 2e-5  # of deterministic cases: single precision, and what Mitsuba's offset moves on smooth parts
SLOPE, SLOPE_BAND = -0.5, 0.06
FEWEST = 0.02  # of the picture's pixels must be compared
MOST_EDGES = 0.25
NOISE_SHARE = 0.5
LEVEL = 0.01  # of the whole picture: a faultless renderer is refused once in a hundred seeds
UNSEEN = 3.0  # events
ROUNDING = 2e-6  # relative to 1 + colour: fp32 along a path
OFFSET = 2 * 9e-5  # of ray origins, relative to max(1, |p|), which is at least half of 1 + |p|
PROBES = 8
SECONDS_PER_CASE = 120.0


def run(cases: Sequence[Case], folder: Path, *, limit: float = SECONDS_PER_CASE, jobs: int = 2,
        progress: Progress | None = None, cluster: str | None = None) -> Transport:
    """Measures `cases`, `jobs` at a time, within `limit` seconds each; writes nothing but what it keeps of cases."""
    start, kept = time.monotonic(), Store(folder, FOLDER)
    by_key = {key(case): case for case in cases}
    # the long ones first, so that none is left alone at the end
    tasks = [Task(k, case.id, f"{__name__}:answer", {"case": case.id, "planes": str(kept.file(k))}, limit)
             for k, case in sorted(by_key.items(), key=lambda item: -sum(item[1].ladder))]
    with engine(jobs, progress, cluster) as pool:
        records = complete(tasks, kept, pool, CaseRecord.model_validate_json, partial(_settled, by_key, kept), arrays=True)
    return Transport(**head(start), cases=[records[k] for k in by_key])


def key(case: Case) -> str:
    """A hash of all that can change the case: its scene, and the code, which holds the case itself."""
    return store.key(case.id, case.scene.hash, made_by=(__name__,))


def _settled(cases: dict[str, Case], kept: Store, task: Task, answer: dict) -> CaseRecord:
    case, state, message = cases[task.key], answer["state"], answer.get("message", "")
    about = {"id": case.id, "title": case.title, "effect": case.effect, "because": case.because, "key": task.key,
             "kind": "finding" if case.is_finding else "equal", "samples": list(case.ladder),
             "judged": "Monte Carlo" if case.ladder else "deterministic", "width": case.scene.camera.width,
             "height": case.scene.camera.height, "command": f"raytruth transport {case.id}"}
    if state == "ok":
        try:
            facts = answer["facts"]
            gates, metrics = [Gate.model_validate(gate) for gate in facts["gates"]], facts["metrics"]
            store.load(kept.file(task.key))
            return CaseRecord(**about, state=state, holds=bool(gates) and all(gate.holds for gate in gates),
                              reason=_reason(case, gates, metrics), gates=gates, metrics=metrics,
                              planes=kept.relative(task.key), seconds=facts["seconds"])
        except (KeyError, ValueError, TypeError, OSError, ValidationError):
            state, message = "malformed", "answered something that is no measurement"
    return CaseRecord(**about, state=state, message=message, holds=False, reason=f"not measured: {message}")


def _reason(case: Case, gates: list[Gate], metrics: dict) -> str:
    broken = [gate for gate in gates if not gate.holds]
    if broken:
        name, value, limit = broken[0].name, broken[0].value, broken[0].limit
        return f"{name} is {'nothing' if value is None else format(value, '.3g')}, the limit is {limit:.3g}"
    measured = {gate.name: gate.value for gate in gates}
    if case.ladder:
        close = (f"no value deviates by more than {measured['largest z']:.1f} times its noise, and the error falls "
                 f"with the power {metrics['slope']:.3f} of the samples")
    else:
        close = f"99 % of the pixels agree to {measured['color p99']:.1e}, and none away from edges differs visibly"
    if not case.is_finding:
        return close
    return (f"the pictures differ by {metrics['mean difference from the document']:.2g} in the mean and "
            f"{metrics['largest difference from the document']:.2g} at most; with what physics predicts {close}")


def answer(arguments: dict) -> dict:
    """In a worker: measures a case by its id, and writes its pictures."""
    start, (case,) = time.monotonic(), find([arguments["case"]])
    measured = measure(case)
    store.save(Path(arguments["planes"]), document=measured.document, mitsuba=measured.mitsuba, expected=measured.expected,
               compared=measured.compared)
    return {"state": "ok", "facts": {"gates": [gate.model_dump() for gate in measured.gates], "metrics": measured.metrics,
                                     "seconds": round(time.monotonic() - start, 2)}}


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


def measure(case: Case) -> Measured:
    """Renders both pictures of `case` and judges them."""
    picture, allowance = document_picture(case.scene)
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
        image, gates, metrics = _monte_carlo(case, expected, allowance, smooth)
    else:
        image, gates, metrics = _deterministic(case, expected, compared, smooth)
    difference = pixel_error(picture.color, image.mean)[compared]
    metrics |= {"pixels": int(compared.size), "pixels compared": pixels, "edge pixels": edges,
                "mean difference from the document": float(difference.mean()),
                "largest difference from the document": float(difference.max())}
    return Measured(picture.color, image.mean, expected, compared, gates + coverage, metrics)


def _deterministic(case: Case, expected, compared, smooth):
    image = case.mitsuba(case.scene, 1, 0)
    error = pixel_error(expected, image.mean)
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
    return image, gates, metrics


def _monte_carlo(case: Case, expected, allowance, smooth):
    runs = {samples: case.mitsuba(case.scene, samples, seed) for seed, samples in enumerate(case.ladder)}
    image = runs[max(runs)]
    branches = largest_around(image.variance.max(axis=-1)) > 0  # a neighbour may have met what a pixel has not
    # where noise outweighs what the offset may do
    noisy = smooth & (allowance < NOISE_SHARE * np.sqrt(image.variance.max(axis=-1)))
    rms = lambda values: float(np.sqrt(np.mean(values[noisy] ** 2))) if noisy.any() else math.nan
    errors = {n: rms(run.mean - expected) for n, run in runs.items()}
    allowed = np.where(np.isfinite(allowance), allowance, 0)
    every = scores(image, expected, allowed, branches)
    z = every[smooth]
    lost = int((~np.isfinite(image.mean[smooth])).sum())
    found = slope(errors)
    gates = [
        _gate("not finite", lost, 0, "values", "values that are NaN or infinite"),
        _gate("largest z", float(np.abs(z).max()), sidak_limit(z.size), "deviations",
              f"the largest deviation of {z.size} values in units of their own noise; the limit is Sidak's at 1 %"),
        _gate("slope", abs(found - SLOPE), SLOPE_BAND, "exponent",
              f"how far the error's exponent is from -1/2: it falls with the {found:.3f}th power of the samples")]
    metrics = {"slope": found, "noisy pixels": int(noisy.sum()), "mean z squared of noisy pixels": rms(every) ** 2,
               **{f"rms error at {samples} samples": error for samples, error in errors.items()}}
    return image, gates, metrics


def _gate(name: str, value, limit: float, unit: str, means: str, at_least: bool = False) -> Gate:
    holds = value is not None and (value >= limit if at_least else value <= limit)  # NaN breaks every gate
    return Gate(name=name, value=value, limit=limit, holds=bool(holds), unit=unit, means=means)


def document_picture(scene: Scene) -> tuple[Picture, np.ndarray]:
    """The document's picture, and how far Mitsuba's offset may move each pixel's colour, (h, w); inf at edges.

    Rays that leave a surface start up to 9e-5 (1 + |p|) away from it in Mitsuba, 200 times farther than rounding moves
    them, so that shadows' edges, silhouettes in mirrors and images in glass move. How far is measured as in
    `reference_tracer.tracer.sensitivity`: every ray is moved by that much, at random, several times.
    """
    truth, _ = perturbed(scene, "exact", 0.0, seed=0)
    response = np.zeros(truth.t.shape)
    for k in range(PROBES):
        probe, _ = perturbed(scene, "exact", OFFSET / ORIGIN_UNITS, seed=k + 1)
        response = np.fmax(response, np.abs(probe.color - truth.color).max(axis=-1))
    largest = largest_around(response)
    return truth, np.where((SAFETY * largest > VISIBLE) | (truth.status == UNDECIDED), np.inf, largest)


def sidak_limit(tests: int) -> float:
    """The largest |z| of `tests` independent ones that stays below the LEVEL (Sidak 1967)."""
    each = 1 - (1 - LEVEL) ** (1 / tests)
    return NormalDist().inv_cdf(1 - each / 2)


def scores(image: Radiance, expected: np.ndarray, allowance: np.ndarray, branches: np.ndarray) -> np.ndarray:
    """z of every pixel and channel, (h, w, 3).

    A sample variance knows nothing of rare paths that no sample took: where paths branch, a few events of the largest
    radiance in the picture are added, in the number of which the tail of a Poisson law meets that of the normal one.
    `allowance` (h, w) is what differs for known reasons.
    """
    unseen = UNSEEN * expected.max() / image.samples * branches
    variance = image.variance + (unseen**2 + allowance**2)[..., None] + (ROUNDING * (1 + expected)) ** 2
    return (image.mean - expected) / np.sqrt(variance)


def slope(errors: dict[int, float]) -> float:
    """The exponent with which root mean square errors fall with the number of samples."""
    samples, values = np.log(np.array(sorted(errors.items()))).T
    return float(np.polyfit(samples, values, 1)[0])
