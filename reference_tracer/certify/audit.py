"""The audit: python-flint decides sampled rays on its own, and both methods' claims are held against it."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from flint import ctx

from ..tracer.world import World
from .certificate import Audit
from .objects import local_rays
from .records import KINDS, NOTHING, allowance, settled_within, undecided
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
    else:
        _hold_against(result, row, verdict, blame)


def _hold_against(result: Audit, row: np.void, verdict: Verdict, blame: Blame) -> None:
    """Whatever a method vouches for is held against the exact answer, whether the other one does or not."""
    proven = not undecided(row.reshape(1))[0]
    radius = float(row["radius"])
    if proven:
        if not verdict.agrees(row["proven"], radius):
            result.contradictions += 1
            blame("proof contradicted", row, _index(verdict, row["proven"]), f"exact: {verdict}")
        elif verdict.hits:
            result.largest_share = max(result.largest_share, verdict.error(row["proven"]) / radius)
    if row["audited"]["undecided"] or not row["smooth"]:
        return
    if fault := audited_fault(verdict, row, proven):
        result.wrong += 1
        blame(fault, row, _index(verdict, row["audited"]), f"exact: {verdict}")
    elif verdict.hits:
        result.largest_error = max(result.largest_error, verdict.error(row["audited"]))


def audited_fault(verdict: Verdict, row: np.void, proven: bool) -> str:
    """What is wrong by exact decision with an answer that the audited method vouches for; empty where nothing is."""
    if verdict.tied:
        return "decided at a tie"
    one = row.reshape(1)
    allowed = row["radius"] + allowance(one)[0] if proven else settled_within(one)[0]
    return "" if verdict.agrees(row["audited"], float(allowed)) else "wrong by exact decision"


def _index(verdict: Verdict, answer) -> int:
    return next(iter(verdict.hits)) if verdict.hits else int(answer["index"])
