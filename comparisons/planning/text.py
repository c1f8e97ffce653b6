"""A plan as text."""

from __future__ import annotations

from .results import DecisionRecord, MeshTrial, Plan, Saved


def told(plan: Plan) -> str:
    """What was decided and why, what is proven, what is saved."""
    head = f"{plan.scene}, {plan.width} x {plan.height}, tolerance {plan.tolerance:g}"
    widths = [max(len(row[k]) for row in map(_cells, plan.decisions)) for k in range(3)] if plan.decisions else []
    row = lambda d: "  ".join([*(cell.ljust(width) for cell, width in zip(_cells(d), widths)), d.evidence])
    rows = ["  " + row(d).rstrip() for d in plan.decisions]
    return "\n".join([head, *rows, f"  {_proof(plan)}", f"  {_saved(plan.saved)}", *map(_mesh, plan.meshes)])


def _cells(d: DecisionRecord) -> tuple[str, str, str]:
    if d.withdrawn:
        return d.parameter, d.written, "withdrawn"
    return d.parameter, d.written, f"-> {d.planned}" if d.changed else "stays"


def _proof(plan: Plan) -> str:
    proof = plan.proof
    word = "PROVEN" if proof.holds else "NOT PROVEN"
    excused = f"; rounding excuses {proof.excused} more (at most {proof.most_excused})" if proof.excused else ""
    attempt = f"; attempt {plan.attempts}" if plan.attempts > 1 else ""
    largest = f"largest difference {proof.largest:.2g}"
    return (f"{word} on {proof.held_back:,} pixels held back: {largest}{excused}{attempt}; "
            f"found in {plan.seconds:.0f} s, {plan.cpu_seconds:.0f} s of processor time")


def _saved(saved: Saved) -> str:
    ratios = (saved.exact, "with exact"), (saved.paper, "with paper"), (saved.call, "by whole calls with exact")
    times = ", ".join(f"{r.value:.2f} x ({r.spread.low:.2f} to {r.spread.high:.2f}) {words}" for r, words in ratios)
    return (f"FASTER than as written by {saved.exact.clock} time: {times}; {saved.turns} turns; "
            f"{saved.rays_planned:,} of {saved.rays_written:,} rays")


def _mesh(trial: MeshTrial) -> str:
    if trial.state != "ok":
        return f"  meshes of {trial.resolution}: {trial.state}, {trial.message}"
    if trial.over == 0:
        return f"  meshes of {trial.resolution}: as good, largest difference {trial.largest:.2g}"
    return f"  meshes of {trial.resolution}: {trial.over} pixels over the tolerance, up to {trial.largest:.2g}"
