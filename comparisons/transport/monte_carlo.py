"""Judging Monte Carlo: is the difference of every pixel's mean from its expectation what its own noise allows?"""

from __future__ import annotations

from statistics import NormalDist

import numpy as np

from converters.mitsuba.radiance import Radiance

LEVEL = 0.01  # of the whole picture: a faultless renderer is refused once in a hundred seeds
UNSEEN = 3.0  # events
ROUNDING = 2e-6  # relative to 1 + colour: fp32 along a path


def limit(tests: int) -> float:
    """The largest |z| of `tests` independent ones that stays below the LEVEL (Sidak 1967)."""
    each = 1 - (1 - LEVEL) ** (1 / tests)
    return NormalDist().inv_cdf(1 - each / 2)


def scores(seen: Radiance, expected: np.ndarray, allowance: np.ndarray, branches: np.ndarray) -> np.ndarray:
    """z of every pixel and channel, (h, w, 3).

    A sample variance knows nothing of rare paths that no sample took: where paths branch, a few events of the largest
    radiance in the picture are added, in the number of which the tail of a Poisson law meets that of the normal one.
    `allowance` (h, w) is what differs for known reasons.
    """
    unseen = UNSEEN * expected.max() / seen.samples * branches
    variance = seen.variance + (unseen**2 + allowance**2)[..., None] + (ROUNDING * (1 + expected)) ** 2
    return (seen.mean - expected) / np.sqrt(variance)


def slope(errors: dict[int, float]) -> float:
    """The exponent with which root mean square errors fall with the number of samples."""
    samples, values = np.log(np.array(sorted(errors.items()))).T
    return float(np.polyfit(samples, values, 1)[0])
