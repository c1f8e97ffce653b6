"""The points that nothing beats in both: less error, less cost (Pareto)."""

from __future__ import annotations

from collections.abc import Iterable


def frontier(points: Iterable[tuple[float, float]]) -> list[tuple[float, float]]:
    """Of points (cost, error) those that no other one equals or beats in both, by rising cost and falling error."""
    best: list[tuple[float, float]] = []
    for cost, error in sorted(set(points)):
        if not best or error < best[-1][1]:
            best.append((cost, error))
    return best
