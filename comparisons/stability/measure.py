"""Runs every method on a family, holds rates against laws, and lists what must not happen."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

from . import families
from .family import Family, Outcome
from .law import Law, band, curve
from .methods import METHODS, Method
from .outcome import WRONG
from .results import Examined, FamilyRecord, Finding, LawPoint, LawRecord, Point, Series

Outcomes = dict[tuple[Method, int], list[Outcome | None]]


def answer(arguments: dict) -> dict:
    """In a worker: one family, by its id, under all methods."""
    family, = families.find([arguments["family"]])
    return {"state": "ok", **examine(family, METHODS, arguments["rays"]).model_dump(mode="json", include={"record", "findings"})}


def examine(family: Family, methods: Sequence[Method], rays: int) -> Examined:
    """One family, with `rays` random rays at every value of its difficulty."""
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
    return Examined(record=record, findings=_unflagged(family, outcomes) + _broken_laws(record))


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
    """Wrong answers of methods that claim exactness, in double precision, where they are theirs to answer for."""
    about, findings = family.about, []
    for (method, precision), result in outcomes.items():
        if precision != 64 or not method.claims or not about.answerable:
            continue
        kinds, values, rates, example = Counter(), [], [], None
        for value, outcome in zip(about.values, result):
            wrong = {kind: n for kind, n in outcome.counts.items() if kind in WRONG} if outcome else {}
            if wrong:
                kinds.update(wrong)
                values.append(value)
                rates.append(sum(wrong.values()) / sum(outcome.counts.values()))
                example = example or outcome.example
        if values:
            names = [kind for kind, _ in kinds.most_common()]
            sentence = (f"{method.name} claims exactness, and up to {max(rates):.1%} of its answers are wrong "
                        f"({', '.join(names)}) and not flagged, at {_listed(values)}")
            findings.append(Finding(what="wrong and not flagged", family=about.id, method=method.name, values=values,
                                    rates=rates, kinds=names, sentence=sentence, example=example))
    return findings


def _broken_laws(record: FamilyRecord) -> list[Finding]:
    findings = []
    for law in record.laws:
        off = [p for p in law.points if not p.within]
        if off:
            told = "; ".join(f"{p.measured:.1%} at {p.value:g} in place of {p.expected:.1%} "
                             f"({p.low:.1%} to {p.high:.1%} in this sample)" for p in off)
            findings.append(Finding(
                what="law broken", family=record.id, method=law.method, values=[p.value for p in off],
                rates=[p.measured for p in off], kinds=law.kinds,
                sentence=f"{law.method} does not follow its law: {told}"))
    return findings


def _listed(values: list[float]) -> str:
    return ", ".join(f"{value:g}" for value in values)
