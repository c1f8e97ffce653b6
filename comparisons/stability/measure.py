"""Examines families in workers: runs every method, holds rates against laws, and lists what must not happen.

What is finished is kept by its content.
"""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Iterable, Sequence
from pathlib import Path

import numpy as np
from scipy.stats import binom

from ..execution import store
from ..execution.cluster import engine
from ..execution.pool import Progress, Task, complete
from ..execution.store import Store
from ..suites import head, reader
from . import cases
from .document import (
    FOLDER,
    KINDS,
    WRONG,
    Examined,
    FamilyRecord,
    Finding,
    LawPoint,
    LawRecord,
    MethodRecord,
    Point,
    Series,
    Stability,
)
from .family import SEED, Family, Law, Outcome
from .methods import METHODS, Method

CONFIDENCE = 0.9999  # of the band of one law; with some 200 of them a true law is called broken once in 50 seeds
RAYS = 400
FEWEST_RAYS, MOST_RAYS = 50, 100_000  # fewer: the bands of the laws say nothing
SECONDS_PER_FAMILY = 600.0

Outcomes = dict[tuple[Method, int], list[Outcome | None]]


def run(families: Sequence[Family], folder: Path, *, rays: int = RAYS, jobs: int = 2, limit: float = SECONDS_PER_FAMILY,
        progress: Progress | None = None, cluster: str | None = None) -> Stability:
    """The document of `families` under all methods, with `rays` random rays at every value of a difficulty; writes nothing
    but what it keeps of families."""
    start, kept = time.monotonic(), Store(folder, FOLDER)
    tasks = [Task(store.key(family.about.id, rays, made_by=(__name__,)), family.about.title,
                  f"{__name__}:answer", {"family": family.about.id, "rays": rays}, limit)
             for family in families]
    with engine(jobs, progress, cluster) as pool:
        found = complete(tasks, kept, pool, Examined.model_validate_json, reader(Examined, "measurement"))
    return document_of(families, [found[task.key] for task in tasks], METHODS, rays, start)


def document_of(families: Sequence[Family], examined: Iterable[Examined], methods: Sequence[Method], rays: int,
                start: float) -> Stability:
    """What was examined since `start`, a time.monotonic(); a family that could not be is among the findings."""
    records, findings = [], []
    for family, found in zip(families, examined, strict=True):
        if found.record is None:
            findings.append(Finding(what="not measured", family=family.about.id, method="", values=[], rates=[], kinds=[],
                                    sentence=f"not measured: {found.state}: {found.message}"))
        else:
            records.append(found.record)
            findings += found.findings
    used = {m.name: m for family in families for m in (*methods, *family.variants)}
    return Stability(
        **head(start), seed=SEED, rays=rays, confidence=CONFIDENCE, kinds=KINDS, families=records, findings=findings,
        methods=[MethodRecord(name=m.name, title=m.title, claims=m.claims, wrong_variant=m.wrong_variant)
                 for m in used.values()])


def answer(arguments: dict) -> dict:
    """In a worker: one family, by its id, under all methods."""
    family, = cases.find([arguments["family"]])
    examined = examine(family, METHODS, arguments["rays"])
    return {"state": "ok", **examined.model_dump(mode="json", include={"record", "findings"})}


def examine(family: Family, methods: Sequence[Method], rays: int) -> Examined:
    """One family, with `rays` random rays at every value of its difficulty."""
    about = family.about
    outcomes: Outcomes = {}
    for precision in about.precisions:
        drawn = family.cases(precision, rays)
        for method in (*methods, *family.variants):
            result = family.run(drawn, method, precision)
            if result is not None:
                outcomes[method, precision] = result
    series = [Series(method=m.name, precision=precision, points=[o.point if o else Point(counts={}) for o in result])
              for (m, precision), result in outcomes.items()]
    in_double = {s.method: s for s in series if s.precision == 64}
    laws = [_held(law, in_double[law.method], about.values) for law in family.laws if law.method in in_double]
    record = FamilyRecord(id=about.id, title=about.title, parameter=about.parameter, values=list(about.values),
                          values_single=list(about.single), labels=list(about.labels), when=about.when, why=about.why,
                          instead=about.instead, series=series, laws=laws)
    return Examined(record=record, findings=_unflagged(family, outcomes) + _broken_laws(record))


def _held(law: Law, series: Series, values: Sequence[float]) -> LawRecord:
    points = []
    for value, point in zip(values, series.points):
        expected = law.rate(value)
        if expected is not None:
            low, high = band(point.rays, expected)
            measured = point.rate(*law.kinds)
            points.append(LawPoint(value=value, expected=expected, low=low, high=high, measured=measured,
                                   within=low <= measured <= high))
    return LawRecord(method=law.method, sentence=law.sentence, kinds=list(law.kinds), curve=curve(law, values),
                     points=points, holds=all(p.within for p in points))


def _unflagged(family: Family, outcomes: Outcomes) -> list[Finding]:
    """Wrong answers of methods that claim exactness, in double precision, where they are theirs to answer for."""
    about, findings = family.about, []
    for (method, precision), result in outcomes.items():
        if precision != 64 or not method.claims or not about.answerable:
            continue
        kinds, values, rates, example = Counter(), [], [], None
        for value, outcome in zip(about.values, result):
            wrong = {kind: n for kind, n in outcome.point.counts.items() if kind in WRONG} if outcome else {}
            if wrong:
                kinds.update(wrong)
                values.append(value)
                rates.append(outcome.point.rate(*WRONG))
                example = example or outcome.example
        if values:
            names = [kind for kind, _ in kinds.most_common()]
            sentence = (f"{method.name} claims exactness, and up to {max(rates):.1%} of its answers are wrong "
                        f"({', '.join(names)}) and not flagged, at {', '.join(f'{v:g}' for v in values)}")
            findings.append(Finding(what="wrong and not flagged", family=about.id, method=method.name, values=values,
                                    rates=rates, kinds=names, sentence=sentence, example=example))
    return findings


def _broken_laws(record: FamilyRecord) -> list[Finding]:
    findings = []
    for law in record.laws:
        off = [p for p in law.points if not p.within]
        if off:
            points = "; ".join(f"{p.measured:.1%} at {p.value:g} in place of {p.expected:.1%} "
                               f"({p.low:.1%} to {p.high:.1%} in this sample)" for p in off)
            findings.append(Finding(
                what="law broken", family=record.id, method=law.method, values=[p.value for p in off],
                rates=[p.measured for p in off], kinds=law.kinds,
                sentence=f"{law.method} does not follow its law: {points}"))
    return findings


def band(rays: int, rate: float, confidence: float = CONFIDENCE) -> tuple[float, float]:
    """The rates between which a sample of `rays` lies with at least `confidence` if each fails with probability `rate`.

    The central interval of the binomial distribution: in each tail at most (1 - confidence) / 2 is left out.
    """
    if rate <= 0 or rate >= 1:
        return rate, rate
    low, high = binom.interval(confidence, rays, rate)
    return float(low) / rays, float(high) / rays


def curve(law: Law, values: tuple[float, ...], points: int = 81) -> list[tuple[float, float]]:
    """(p, rate) along the range of the positive `values`, evenly spaced on a logarithmic axis, where the law speaks."""
    positive = [v for v in values if v > 0]
    if len(positive) < 2:
        return []
    rates = [(p, law.rate(p)) for p in np.geomspace(min(positive), max(positive), points).tolist()]
    return [(p, float(rate)) for p, rate in rates if rate is not None]
