"""Laws against a simulation of the literal method that shares nothing with the tracer: plain NumPy on g(t)."""

import math
from fractions import Fraction

import numpy as np
import pytest

from raytruth.comparisons.stability import cases as families
from raytruth.comparisons.stability.families.model import depth_rate
from raytruth.comparisons.stability.families.roots import horizon_rate
from raytruth.comparisons.stability.measure import CONFIDENCE, band

H, COUNT = 0.05, 40_000


def literal(g, inside, limit):
    """(found, t) of steps of H and 20 free Newton iterations from the middle. `g(t)` gives value and derivative."""
    n = len(inside)
    t, found = np.full(n, np.nan), np.zeros(n, bool)
    with np.errstate(all="ignore"):
        for step in range(1, math.ceil(limit / H) + 1):
            changes = ~found & ((g(np.full(n, step * H))[0] < 0) != inside)
            t[changes], found = (step - 0.5) * H, found | changes
        going = found.copy()
        for _ in range(20):
            value, slope = g(t)
            dt = value / slope
            going &= np.isfinite(dt)
            t = np.where(going, t - dt, t)
            going &= np.abs(dt) > 1e-12 * np.maximum(1, np.abs(t))
    return found, t


def _parabola(near, half):
    return lambda t: ((t - near) ** 2 - half**2, 2 * (t - near))


def grazing(p, random):
    near = 3 - random.uniform(0, 6 * H, COUNT)
    half = np.full(COUNT, math.sqrt(1 - (1 - p) ** 2))
    return _parabola(near, half), near - half, False, 6.0


def small_ball(r, random):
    near = 3 - random.uniform(0, 6 * H, COUNT)
    half = r * np.sqrt(random.uniform(0, 1, COUNT))  # of chords of points uniform on a disc
    return _parabola(near, half), near - half, False, 6.0


def thin_shell(p, random):
    near, b = 3 - random.uniform(0, 6 * H, COUNT), random.uniform(0, 0.7, COUNT)

    def g(t):
        q = (t - near) ** 2 + b * b - 1
        return q * q - p * p, 4 * q * (t - near)

    return g, near - np.sqrt(1 + p - b * b), False, 6.0


def steep(p, random):
    k, root = p / H, 1.37 + random.uniform(0, H, COUNT)
    square = lambda t: 1 + (k * (t - root)) ** 2
    return (lambda t: ((t - root) / np.sqrt(square(t)), square(t) ** -1.5)), root, True, 3.0


def multiple_root(m, random):
    root = 1.37 + random.uniform(0, H, COUNT)
    return (lambda t: ((t - root) ** m, m * (t - root) ** (m - 1))), root, True, 3.0


def pole(p, random):
    at = 1.37 + random.uniform(0, H, COUNT)
    first = at + 1 / p if p else np.full(COUNT, np.inf)
    return (lambda t: (1 / (t - at) - p, -1 / (t - at) ** 2)), first, True, 4.0


def domain_edge(p, random):
    edge = 1.37 + random.uniform(0, H, COUNT)
    g = lambda t: (np.sqrt(edge - t) - math.sqrt(p), -0.5 / np.sqrt(edge - t))
    return g, edge - p, False, 3.0


SIMULATIONS = {"grazing": grazing, "small-ball": small_ball, "thin-shell": thin_shell, "steep": steep,
               "multiple-root": multiple_root, "pole": pole, "domain-edge": domain_edge}


@pytest.mark.parametrize("name", SIMULATIONS)
def test_the_law_is_what_a_simulation_measures(name):
    """Within five standard deviations of 40 000 rays; `wrong` as the suite counts it: missed, or off by too much."""
    family, = families.find([name])
    law, = family.laws
    spoken = 0
    for p in family.about.values:
        rate = law.rate(p)
        if rate is None or 0.9995 < rate < 1:  # too rare a success for 40 000 rays to see
            continue
        g, first, inside, limit = SIMULATIONS[name](p, np.random.default_rng(3))
        found, t = literal(g, np.full(COUNT, inside), limit)
        accuracy = {"domain-edge": min(1e-6, 1e-2 * p), "thin-shell": min(1e-6, p / 10)}.get(name, 1e-6)
        with np.errstate(invalid="ignore"):
            wrong = np.where(np.isfinite(first), ~found | ~(np.abs(t - first) <= accuracy), found)
        deviation = 5 * math.sqrt(max(rate * (1 - rate), 0.01) / COUNT)
        assert wrong.mean() == pytest.approx(rate, abs=deviation), (name, p)
        spoken += 0 < rate < 1
    assert spoken >= 2  # the law says more than "always" and "never"


def test_laws_of_shares_against_drawn_samples():
    random = np.random.default_rng(4)
    for p in (0.02, 0.012, 0.0105, 0.01, 0.009):
        share = np.mean(1 / (np.sin(p) * random.uniform(0.9, 1.1, 100_000)) > 100)
        assert share == pytest.approx(horizon_rate(p), abs=0.01)
    for R in (0.12, 0.13, 0.14, 0.15, 0.2):
        share = np.mean(R**3 * random.uniform(0.5, 1, 100_000) > 1 / 512)
        assert share == pytest.approx(depth_rate(R), abs=0.01)


@pytest.mark.parametrize("rays, rate", [(400, 0.5), (400, 0.01), (400, 0.9975), (60, 0.3)])
def test_the_band_holds_what_it_promises(rays, rate):
    """In rational arithmetic: each tail outside of the band has at most (1 - confidence)/2, one count more has more."""
    low, high = (round(x * rays) for x in band(rays, rate))
    p = Fraction(rate)
    mass = [math.comb(rays, k) * p**k * (1 - p) ** (rays - k) for k in range(rays + 1)]
    tail = Fraction(1 - CONFIDENCE) / 2
    assert sum(mass[:low]) <= tail < sum(mass[:low + 1])
    assert sum(mass[high + 1:]) <= tail < sum(mass[high:])


def test_a_certain_law_has_no_band():
    assert band(400, 0.0) == (0, 0) and band(400, 1.0) == (1, 1)
