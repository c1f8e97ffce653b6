"""A certificate as plain text."""

from __future__ import annotations

from ..text import table
from .certificate import Audit, Certificate, Finding, PathErrors

MOST_SHOWN = 12  # findings, and reasons


def told(c: Certificate) -> str:
    """The certificate for people to read, without a newline at its end."""
    samples = f", {c.samples} x {c.samples} samples a pixel" if c.samples > 1 else ""
    verdict = "holds" if c.passed else "DOES NOT HOLD"
    lines = [f"{c.scene}, {c.width} x {c.height}{samples}, method {c.method}: {verdict}", "",
             *_census(c), *(f"  bounds not proven: {name}; nothing relies on them" for name in c.unproven_bounds),
             *_audit(c.audit), *_paths(c.paths)]
    lines += _list("Wrong:", c.findings) + _list("Undecided by proof:", c.undecided)
    return "\n".join(lines)


def _census(c: Certificate) -> list[str]:
    heads = ("", "rays", "proven hits", "proven misses", "settled", "undecided", "wrong", "refused")
    rows = [(kind, *(f"{v:,}" for v in (k.rays, k.hits, k.misses, k.settled, k.undecided, k.wrong, k.refused)))
            for kind, k in c.kinds.items() if k.rays]
    share = c.undecided_rays / c.rays if c.rays else 0.0
    return [table(heads, rows, indent=2), "", f"  undecided: {share:.1e} of all rays",
                    f"  distances: at most {c.largest_gap:.1e} off the proven one, which holds within at most "
                    f"{c.largest_radius:.1e}"]


def _audit(a: Audit) -> list[str]:
    kinds = ", ".join(f"{n} {kind}" for kind, n in a.by_kind.items())
    undecided = sum(a.undecided.values())
    lines = [f"  audit:     {a.rays:,} rays decided exactly ({kinds}; {a.at_edges} at edges)",
             f"             {a.contradictions} proofs contradicted, {a.wrong} wrong, {undecided} undecided; "
             f"{a.touching} touch an object without crossing it",
             f"             t at most {a.largest_error:.1e} off the exact one; proven t use up to {a.largest_share:.0%} "
             "of their enclosures"]
    return lines + [f"             undecided: {n} rays, {reason}" for reason, n in a.undecided.items()]


def _paths(p: PathErrors) -> list[str]:
    lines = [f"  paths:     {p.paths} pixels recomputed with 77 digits ({p.rays:,} rays, up to generation {p.deepest})",
             f"             colours at most {p.largest_error:.1e} off; {p.above_bar} off by more than {p.bar:.0e}"]
    lines += [f"             {p.not_tried}"] if p.not_tried else []
    lines += [f"             near-critical: {text}" for text in p.near_critical]
    return lines + [f"             wrong: {text}" for text in p.wrong]


def _list(title: str, findings: list[Finding]) -> list[str]:
    if not findings:
        return []
    lines = ["", f"  {title}"]
    for f in findings[:MOST_SHOWN]:
        lines += [f"    {f.count:>8,}  {f.fault}, {f.rays} rays, {f.object}", f"              e.g. {f.example}"]
    if len(findings) > MOST_SHOWN:
        lines.append(f"    and {len(findings) - MOST_SHOWN} more groups")
    return lines
