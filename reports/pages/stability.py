"""The page of failure maps: what every method did at every difficulty, and laws of failure as charts."""

from __future__ import annotations

from dataclasses import dataclass

from raytruth.comparisons.stability.document import (
    FILE,
    KINDS,
    WRONG,
    FamilyRecord,
    Finding,
    LawRecord,
    MethodRecord,
    Point,
    Series,
    Stability,
    read,
)

from ..figures.charts import Axis, Line, chart
from ..text.numbers import Number, parts
from ..text.words import count, slug
from .page import Page, Report, Summary

__all__ = ["FILE", "pages", "read"]

LETTERS = {"correct": "", "missed": "M", "false": "F", "wrong root": "R", "diverged": "D", "non-finite": "N",
           "wrong value": "V", "undecided": "U", "too slow": "S"}
STEPS = ((0.01, 0.002), (0.02, 0.005), (0.05, 0.01), (0.1, 0.02), (0.2, 0.05), (0.5, 0.1), (1.0, 0.25))  # up to; ticks
LEAST_SHARE = 0.15  # of a cell's height that the rarest failure fills, so that it is seen


@dataclass(frozen=True)
class Cell:
    """One method at one difficulty, or at its worst one."""

    kind: str  # the one to colour by; empty where the method does not apply
    fill: float  # percent of the cell's height: the share of rays that are not correct
    text: str  # all in words

    @property
    def letter(self) -> str:
        return LETTERS.get(self.kind, "")

    @property
    def style(self) -> str:
        return self.kind.replace(" ", "-") or "none"


@dataclass(frozen=True)
class Row:
    method: str
    wrong_variant: str  # why it must fail, if it is shown for comparison only
    cells: tuple[Cell, ...]


@dataclass(frozen=True)
class FailureMap:
    precision: int
    columns: tuple[Number, ...]
    rows: tuple[Row, ...]


@dataclass(frozen=True)
class Law:
    """One law, with all methods that it holds for."""

    sentence: str
    counts: str  # what the rate counts, in words
    methods: tuple[str, ...]
    holds: bool
    chart: str | None  # None: the rate is `always` the same, by theory and as measured; a sentence says that
    always: float | None


@dataclass(frozen=True)
class Family:
    record: FamilyRecord
    maps: tuple[FailureMap, ...]  # of double precision, and of single where that was run
    laws: tuple[Law, ...]
    findings: tuple[Finding, ...]

    @property
    def anchor(self) -> str:
        return f"family-{slug(self.record.id)}"

    @property
    def variants(self) -> dict[str, str]:
        """Methods shown for comparison only: why each must fail."""
        return {row.method: row.wrong_variant for row in self.maps[0].rows if row.wrong_variant} if self.maps else {}


@dataclass(frozen=True)
class Failures:
    """The whole document, arranged."""

    document: Stability
    methods: tuple[MethodRecord, ...]  # those that are no wrong variants: the columns of the overview
    families: tuple[Family, ...]  # with findings first
    overview: tuple[tuple[Family, tuple[Cell, ...]], ...]  # the worst cell of every method

    @property
    def findings(self) -> list[tuple[Finding, Family | None]]:
        known = {family.record.id: family for family in self.families}
        return [(finding, known.get(finding.family)) for finding in self.document.findings]


def pages(report: Report) -> list[Page]:
    document = report.documents.get(FILE)
    if document is None:
        return []
    legend = [(kind, Cell(kind, 0.0 if kind == "correct" else 100.0, ""), document.kinds.get(kind, means))
              for kind, means in KINDS.items()]
    shown = failures(document)
    summary = Summary(
        "Where methods fail",
        f"{len(shown.methods)} methods on {count(len(shown.families), 'family', 'families')} of cases, each with one "
        "difficulty that grows until methods break.",
        f"{count(len(document.findings), 'finding')}." if document.findings else
        "No law is broken, and no method that claims exactness is wrong without saying so.", "The failure maps")
    return [Page("stability.html", "stability.html.j2", {"failures": shown, "legend": legend},
                 nav="Where methods fail", summary=summary)]


def failures(document: Stability) -> Failures:
    variants = {m.name: m.wrong_variant for m in document.methods}
    families = [_family(record, variants, [f for f in document.findings if f.family == record.id])
                for record in document.families]
    methods = tuple(m for m in document.methods if not m.wrong_variant)
    overview = tuple((family, tuple(_worst_cell(family.record, m.name) for m in methods)) for family in families)
    families.sort(key=lambda family: not family.findings)  # stable: otherwise in the document's order
    return Failures(document, methods, tuple(families), overview)


def _family(record: FamilyRecord, variants: dict[str, str], findings: list[Finding]) -> Family:
    maps = []
    for precision, values in ((64, record.values), (32, record.values_single)):
        rows = tuple(Row(s.method, variants.get(s.method, ""), tuple(map(_cell, _names(record, precision), s.points)))
                     for s in record.series if s.precision == precision)
        if rows:
            maps.append(FailureMap(precision, tuple(parts(value) for value in values), rows))
    return Family(record, tuple(maps), tuple(laws(record)), tuple(findings))


def _names(record: FamilyRecord, precision: int) -> list[str]:
    """The difficulties in words."""
    values = record.values if precision == 64 else record.values_single
    if precision == 64 and len(record.labels) == len(values):
        return list(record.labels)
    return [f"p = {parts(value)}" for value in values]


def _cell(where: str, point: Point) -> Cell:
    if not point.counts:
        return Cell("", 0.0, f"{where}: does not apply")
    text = ", ".join(f"{_percent(n, point.rays)} {kind}" for kind, n in
                     sorted(point.counts.items(), key=lambda item: -item[1]))
    text += f"; largest error {parts(float(f'{point.worst_error:.0e}'))}" if point.worst_error is not None else ""
    text += f"; {parts(point.evaluations)} evaluations a ray" if point.evaluations is not None else ""
    return Cell(point.worst, _fill(1 - point.rate("correct")), f"{where}: {text}")


def _worst_cell(record: FamilyRecord, method: str) -> Cell:
    """The method's worst difficulty in double precision: most wrong answers, then fewest correct ones."""
    series: Series | None = next((s for s in record.series if s.method == method and s.precision == 64), None)
    ran = [(name, p) for name, p in zip(_names(record, 64), series.points) if p.counts] if series else []
    if not ran:
        return Cell("", 0.0, f"{method}: does not apply")
    name, point = max(ran, key=lambda pair: (pair[1].rate(*WRONG), 1 - pair[1].rate("correct")))
    wrong = {kind: n for kind, n in point.counts.items() if kind in WRONG}
    if wrong:
        kind, share = max(wrong, key=wrong.get), point.rate(*WRONG)
        return Cell(kind, _fill(share), f"{method}: {_percent(share * point.rays, point.rays)} wrong at {name}")
    cell = _cell(name, point)
    if cell.kind == "correct":
        return Cell("correct", 0.0, f"{method}: correct everywhere")
    return Cell(cell.kind, cell.fill, f"{method}: nothing wrong; at worst {cell.text}")


def _fill(share: float) -> float:
    return 0.0 if share <= 0 else round(100 * (LEAST_SHARE + (1 - LEAST_SHARE) * share), 1)


def _percent(count: float, total: int) -> str:
    return f"{100 * count / total:.3g} %"


def laws(family: FamilyRecord) -> list[Law]:
    """The laws of a family, broken ones first; methods that obey the same one share a chart."""
    groups: dict[tuple, list[LawRecord]] = {}
    for law in family.laws:
        expected = tuple((p.value, p.expected, p.low, p.high) for p in law.points)
        groups.setdefault((law.sentence, tuple(law.kinds), tuple(law.curve), expected, law.holds), []).append(law)
    found = [_law(family, members, f"law-{slug(family.id)}-{k}") for k, members in enumerate(groups.values())]
    return sorted(found, key=lambda law: (law.holds, law.chart is None))


def _law(family: FamilyRecord, members: list[LawRecord], anchor: str) -> Law:
    first = members[0]
    rates = {rate for _, rate in first.curve} | {r for m in members for p in m.points for r in (p.expected, p.measured)}
    always = next(iter(rates)) if len(rates) == 1 and rates <= {0.0, 1.0} else None
    counts = "wrong answers" if set(first.kinds) == set(WRONG) else f"{' or '.join(first.kinds)} answers"
    drawn = None if always is not None else _chart(family, first, law_lines(members), counts, anchor)
    return Law(first.sentence, counts, tuple(law.method for law in members), first.holds, drawn, always)


def law_lines(members: list[LawRecord]) -> list[Line]:
    """What theory says, where a sample of this size must lie, and what was measured: the same by the same marks."""
    first = members[0]
    same: dict[tuple, list[str]] = {}
    for law in members:
        same.setdefault(tuple(p.measured for p in law.points), []).append(law.method)
    return [Line("by theory", first.curve, 5, "plain"),
            Line("", [(p.value, p.expected) for p in first.points], 5, "bands", [(p.low, p.high) for p in first.points]),
            *(Line(", ".join(names), [(p.value, rate) for p, rate in zip(first.points, measured)], number % 5, "apart",
                   off=[not p.low <= rate <= p.high for p, rate in zip(first.points, measured)])
              for number, (measured, names) in enumerate(same.items()))]


def _chart(family: FamilyRecord, law: LawRecord, lines: list[Line], counts: str, anchor: str) -> str:
    """Easy on the left and hard on the right, as in the map; p = 0 has a place beyond the axis."""
    rates = [rate for line in lines for _, rate in line.points] + [p.high for p in law.points]
    step = next((step for top, step in STEPS if top >= max(rates)), STEPS[-1][1])
    return chart(anchor, f"{family.title}: {law.sentence}",
                 Axis(family.parameter, [x for line in lines for x, _ in line.points], zero="0", few=True,
                      falls=family.values[0] > family.values[-1]),
                 Axis(f"share of rays: {counts}", rates, step=step,
                      write=lambda value: f"{100 * value:.{0 if step >= 0.01 else 1}f} %"), lines)
