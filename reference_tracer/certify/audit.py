"""The audit: python-flint decides sampled rays on its own, and both methods' claims are held against it."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from flint import ctx

from ..world import World
from .certificate import Audit
from .objects import local_rays
from .records import KINDS, NOTHING, allowance, undecided
from .verdict import Verdict, decide

PRECISION = 192  # bits of the comparisons

Blame = Callable[[str, np.void, int, str], None]


def audit(proofs: World, rows: np.ndarray, blame: Blame, progress: Callable[[float], None]) -> Audit:
    """Decides `rows` (records.py). `blame(fault, row, object, text)` is called for every contradiction."""
    result = Audit()
    local = local_rays(proofs, rows) if len(rows) else None
    with ctx.workprec(PRECISION):
        for k, row in enumerate(rows):
            _record(result, row, decide(proofs.scene, row, local[:, k]), blame)
            progress((k + 1) / len(rows))
    return result


def _record(result: Audit, row: np.void, verdict: Verdict, blame: Blame) -> None:
    kind = KINDS[row["kind"]]
    result.rays += 1
    result.by_kind[kind] = result.by_kind.get(kind, 0) + 1
    result.at_edges += bool(row["edge"])
    result.touching += verdict.touches
    if verdict.wrong_side != NOTHING:
        result.wrong += 1
        blame("wrong side", row, verdict.wrong_side, "f at the origin has the other sign")
    elif verdict.undecided:
        result.undecided[verdict.undecided] = result.undecided.get(verdict.undecided, 0) + 1
    elif not undecided(row.reshape(1))[0]:
        _hold_against(result, row, verdict, blame)


def _hold_against(result: Audit, row: np.void, verdict: Verdict, blame: Blame) -> None:
    radius = float(row["radius"])
    claims = (("proven", "contradictions", "proof contradicted", radius),
              ("audited", "wrong", "wrong by exact decision", radius + float(allowance(row.reshape(1))[0])))
    for name, counter, fault, allowed in claims:
        answer = row[name]
        if answer["undecided"]:
            continue
        if not verdict.agrees(answer, allowed):
            setattr(result, counter, getattr(result, counter) + 1)
            index = next(iter(verdict.hits)) if verdict.hits else int(answer["index"])
            blame(fault, row, index, f"exact: {verdict}")
        elif verdict.hits and name == "audited":
            result.largest_error = max(result.largest_error, verdict.error(answer))
        elif verdict.hits:
            result.largest_share = max(result.largest_share, verdict.error(answer) / radius)
