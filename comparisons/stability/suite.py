"""Runs every method on every family, holds rates against laws, and lists what must not happen."""

from __future__ import annotations

import time
from collections.abc import Sequence
from datetime import UTC, datetime

from ..machine import machine
from ..progress import Progress
from .family import SEED, Family, Outcome
from .law import CONFIDENCE, Law, band, curve
from .methods import METHODS, Method
from .outcome import KINDS, WRONG
from .results import FamilyRecord, Finding, LawPoint, LawRecord, MethodRecord, Point, Series, Stability

RAYS = 400
FEWEST_RAYS = 50  # below, the bands of the laws say nothing

Outcomes = dict[tuple[Method, int], list[Outcome | None]]


def run(families: Sequence[Family], methods: Sequence[Method] = METHODS, rays: int = RAYS, quiet: bool = True) -> Stability:
    """The document of `families` under `methods`, with `rays` random rays at every value of a difficulty."""
    start = time.monotonic()
    progress = Progress(len(families), quiet)
    records, findings = [], []
    for family in families:
        progress.show(family.about.title)
        record, found = examine(family, methods, rays)
        records.append(record)
        findings += found
        progress.step()
    progress.close()
    used = {m.name: m for family in families for m in (*methods, *family.variants)}
    return Stability(
        created=datetime.now(UTC).isoformat(timespec="seconds"), seconds=round(time.monotonic() - start, 3),
        machine=machine(), seed=SEED, rays=rays, confidence=CONFIDENCE, kinds=KINDS, families=records, findings=findings,
        methods=[MethodRecord(name=m.name, title=m.title, claims=m.claims, wrong_variant=m.wrong_variant)
                 for m in used.values()])


def examine(family: Family, methods: Sequence[Method], rays: int) -> tuple[FamilyRecord, list[Finding]]:
    """One family: its record, and its findings."""
    about = family.about
    outcomes: Outcomes = {}
    for precision in about.precisions:
        cases = family.cases(precision, rays)
        for method in (*methods, *family.variants):
            result = family.run(cases, method, precision)
            if result is not None:
                outcomes[method, precision] = result
    series = [Series(method=m.name, precision=precision, points=[_point(o) for o in result])
              for (m, precision), result in outcomes.items()]
    in_double = {s.method: s for s in series if s.precision == 64}
    laws = [_held(law, in_double[law.method], about.values) for law in family.laws if law.method in in_double]
    record = FamilyRecord(id=about.id, title=about.title, parameter=about.parameter, values=list(about.values),
                          values_single=list(about.single), labels=list(about.labels), when=about.when, why=about.why,
                          instead=about.instead, series=series, laws=laws)
    return record, _unflagged(family, outcomes) + _broken_laws(record)


def _point(outcome: Outcome | None) -> Point:
    if outcome is None:
        return Point(counts={})
    return Point(counts=outcome.counts, worst_error=outcome.worst_error, evaluations=outcome.evaluations)


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
    """Wrong answers of methods that claim exactness, in double precision, where a finding is theirs to answer for."""
    findings = []
    for (method, precision), result in outcomes.items():
        if precision != 64 or not method.claims or not family.about.answerable:
            continue
        for value, outcome in zip(family.about.values, result):
            wrong = {kind: n for kind, n in outcome.counts.items() if kind in WRONG} if outcome else {}
            if wrong:
                kind = max(wrong, key=wrong.get)
                rate = sum(wrong.values()) / sum(outcome.counts.values())
                findings.append(Finding(
                    what="wrong and not flagged", family=family.about.id, method=method.name, value=value, kind=kind,
                    rate=rate, example=outcome.example,
                    sentence=f"{method.name} claims exactness, and {rate:.1%} of its answers are wrong ({kind}) at "
                             f"{value:g} of {family.about.id}"))
    return findings


def _broken_laws(record: FamilyRecord) -> list[Finding]:
    return [Finding(what="law broken", family=record.id, method=law.method, value=p.value, rate=p.measured,
                    sentence=f"{law.method} fails on {p.measured:.1%} of the rays at {p.value:g} of {record.id}; "
                             f"by the law it is {p.expected:.1%}, in this sample {p.low:.1%} to {p.high:.1%}")
            for law in record.laws for p in law.points if not p.within]
