"""Every kind of answer, one made by hand for each."""

import numpy as np
import pytest

from raytruth.comparisons.stability.document import KINDS, MOST_EVALUATIONS, NAMES
from raytruth.comparisons.stability.family import Answer, Draw, Rays, classify

INF, NAN = np.inf, np.nan
CASES = [  # exact distance, other root, found, t, undecided, evaluations: kind
    (2.0, 3.0, True, 2.0 + 5e-7, False, 10, "correct"),
    (INF, INF, False, 0.0, False, 10, "correct"),
    (2.0, 3.0, False, 0.0, False, 10, "missed"),
    (INF, 3.0, True, 3.0, False, 10, "false"),
    (2.0, 3.0, True, 3.0, False, 10, "wrong root"),
    (2.0, 3.0, True, 2.5, False, 10, "diverged"),
    (2.0, 3.0, True, INF, False, 10, "non-finite"),
    (2.0, 3.0, True, NAN, False, 10, "non-finite"),
    (2.0, 3.0, True, 2.5, True, 10, "undecided"),
    (INF, INF, False, 0.0, True, 10, "undecided"),
    (2.0, 3.0, True, 2.0, False, MOST_EVALUATIONS + 1, "too slow"),
    (2.0, 3.0, True, 3.0, False, MOST_EVALUATIONS + 1, "wrong root"),
    (2.0, 3.0, True, 2.0, True, MOST_EVALUATIONS + 1, "undecided"),
    (NAN, INF, True, 2.0, False, 10, "false"),  # f is undefined on the way: only "undecided" is right (M7)
    (NAN, INF, False, 0.0, False, 10, "false"),
    (NAN, INF, True, 2.0, True, 10, "correct")]


@pytest.mark.parametrize("first, other, found, t, undecided, evaluations, kind", CASES)
def test_kinds(first, other, found, t, undecided, evaluations, kind):
    rays = Rays.of(np.zeros((1, 3)), np.ones((1, 3)), first=first, others=[[other]])
    answer = Answer(*(np.array([v]) for v in (found, t, undecided, evaluations)))
    assert NAMES[classify(rays, answer)[0]] == kind


def test_every_kind_of_a_single_surface_is_told():
    assert {case[-1] for case in CASES} == set(KINDS) - {"wrong value"}


def test_batches_keep_every_ray():
    """Joined batches hold the rays of their parts in order; missing other roots are filled with infinity."""
    parts = [Rays.of(np.full((n, 3), n), np.ones((n, 3)), first=float(n), others=np.full((n, k), n), c=n)
             for n, k in ((2, 1), (3, 0), (1, 2))]
    rays = Rays.joined(parts)
    assert rays.first.tolist() == [2, 2, 3, 3, 3, 1] == rays.parameters["c"].tolist() == rays.o[:, 1].tolist()
    assert rays.others.tolist() == [[2, INF], [2, INF], [INF, INF], [INF, INF], [INF, INF], [1, 1]]


@pytest.mark.parametrize("precision", [64, 32])
def test_lines_pass_where_they_are_told_to(precision):
    """Distance of the origin from the line o + t d is |o x d| / |d|; stored numbers fit the precision."""
    draw = Draw(200, np.random.default_rng(1), precision)
    impact = np.linspace(0, 2, 200)
    o, d = draw.lines(impact, 3.0, jitter=0.3)
    np.testing.assert_allclose(np.linalg.norm(np.cross(o, d), axis=1), impact, atol=1e-14 if precision == 64 else 1e-6)
    nearest = -np.sum(o * d, axis=1)
    assert nearest.min() > 2.69 and nearest.max() < 3.01 and np.ptp(nearest) > 0.28
    if precision == 32:
        assert np.array_equal(o, o.astype(np.float32)) and np.array_equal(d, d.astype(np.float32))
