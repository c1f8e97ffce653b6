"""Failure maps: what every method did at every difficulty, as cells with a colour and a letter."""

from __future__ import annotations

from dataclasses import dataclass

from comparisons.stability.document import WRONG
from comparisons.stability.document import FamilyRecord, Finding, MethodRecord, Point, Series, Stability

from .law_plot import Law, laws
from .names import slug
from .numbers import Number, parts

LETTERS = {"correct": "", "missed": "M", "false": "F", "wrong root": "R", "diverged": "D", "non-finite": "N",
           "wrong value": "V", "undecided": "U", "too slow": "S"}
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
    return [f"p = {value:g}" for value in values]


def _cell(where: str, point: Point) -> Cell:
    if not point.counts:
        return Cell("", 0.0, f"{where}: does not apply")
    told = ", ".join(f"{_percent(n, point.rays)} {kind}" for kind, n in
                     sorted(point.counts.items(), key=lambda item: -item[1]))
    told += f"; largest error {point.worst_error:.1g}" if point.worst_error is not None else ""
    told += f"; {point.evaluations:.3g} evaluations a ray" if point.evaluations is not None else ""
    return Cell(point.worst, _fill(1 - point.rate("correct")), f"{where}: {told}")


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
