"""Laws: how often a method must fail, by theory, and the band in which a sample of rays then has to lie."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from .outcome import WRONG

CONFIDENCE = 0.9999  # of one band; with some 200 of them a true law is called broken once in 50 seeds


@dataclass(frozen=True)
class Law:
    """`rate(p)`: the probability that `method` gives an answer of one of `kinds`; None where theory is silent."""

    method: str
    sentence: str
    rate: Callable[[float], float | None]
    kinds: tuple[str, ...] = WRONG


def band(rays: int, rate: float, confidence: float = CONFIDENCE) -> tuple[float, float]:
    """The rates between which a sample of `rays` lies with at least `confidence` if each fails with probability `rate`.

    The central interval of the binomial distribution: in each tail at most (1 - confidence) / 2 is left out.
    """
    if rate <= 0 or rate >= 1:
        return rate, rate
    k = np.arange(rays + 1)
    choose = np.array([math.lgamma(rays + 1) - math.lgamma(i + 1) - math.lgamma(rays - i + 1) for i in k])
    mass = np.exp(choose + k * math.log(rate) + (rays - k) * math.log1p(-rate))
    tail = (1 - confidence) / 2
    low = int(np.searchsorted(np.cumsum(mass), tail, side="right"))
    high = rays - int(np.searchsorted(np.cumsum(mass[::-1]), tail, side="right"))
    return low / rays, high / rays


def curve(law: Law, values: tuple[float, ...], points: int = 81) -> list[tuple[float, float]]:
    """(p, rate) along the range of the positive `values`, evenly spaced on a logarithmic axis, where the law speaks."""
    positive = [v for v in values if v > 0]
    if len(positive) < 2:
        return []
    grid = np.geomspace(min(positive), max(positive), points).tolist()
    rates = [(p, law.rate(p)) for p in grid]
    return [(p, float(rate)) for p, rate in rates if rate is not None]
