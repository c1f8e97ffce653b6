"""Axes of charts: from values to coordinates, and where their ticks stand."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

from .numbers import Number, is_plain, parts, power

MOST_TICKS = 7


@dataclass(frozen=True)
class Tick:
    at: float
    label: Number


@dataclass(frozen=True)
class LogAxis:
    """A logarithmic axis from value `low` at coordinate `start` to value `high` at coordinate `end`."""

    low: float
    high: float
    start: float
    end: float

    @property
    def range(self) -> tuple[float, float]:
        return self.low, self.high

    def at(self, value: float) -> float:
        position = math.log(value / self.low) / math.log(self.high / self.low)
        return round(self.start + position * (self.end - self.start), 2)

    def ticks(self, values: list[float]) -> tuple[Tick, ...]:
        write = parts if all(map(is_plain, values)) else power  # one notation an axis
        return tuple(Tick(self.at(value), write(value)) for value in values)

    def apart(self, values: list[float], distance: float) -> bool:
        at = [self.at(value) for value in values]
        return all(abs(b - a) >= distance for a, b in zip(at, at[1:]))


@dataclass(frozen=True)
class LinearAxis:
    """An axis from value 0 at coordinate `start` to value `high` at coordinate `end`."""

    high: float
    start: float
    end: float

    def at(self, value: float) -> float:
        return round(self.start + value / self.high * (self.end - self.start), 2)

    def ticks(self, step: float, write: Callable[[float], Number] = parts) -> tuple[Tick, ...]:
        """At 0, step, 2 step, ... up to `high`."""
        values = [k * step for k in range(int(self.high / step + 1e-9) + 1)]
        return tuple(Tick(self.at(value), write(value)) for value in values)


def log_ticks(low: float, high: float) -> list[float]:
    """Round values between `low` and `high`, as many as a chart has room for: 1-2-5, decades, or every n-th decade."""
    first, last = math.floor(math.log10(low)), math.ceil(math.log10(high))
    for digits, stride in [((1, 2, 5), 1), ((1, 3), 1)] + [((1,), stride) for stride in range(1, last - first + 2)]:
        found = [float(f"{digit}e{exponent}") for exponent in range(first, last + 1) if exponent % stride == 0
                 for digit in digits]
        found = [value for value in found if low <= value <= high]
        if len(found) <= MOST_TICKS:
            return found
    return []


def padded(values: list[float], share: float) -> tuple[float, float]:
    """The range of `values`, wider by `share` of its logarithm at both ends; at least a factor of 4 in all."""
    if not values:
        return 0.1, 10.0
    low, high = math.log10(min(values)), math.log10(max(values))
    pad = max(share * (high - low), (math.log10(4) - (high - low)) / 2)
    return 10 ** (low - pad), 10 ** (high + pad)
