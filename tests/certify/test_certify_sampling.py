"""Samples: every stratum has its share, half of it at edges."""

import numpy as np
import pytest

from raytruth.reference_tracer.certify.records import KINDS, row_type
from raytruth.reference_tracer.certify.sample import Reservoir, edge_pixels, shares


@pytest.mark.parametrize("available, goal, expected", [
    ([10, 10, 10], 9, [3, 3, 3]), ([1, 10, 10], 9, [1, 4, 4]), ([2, 3], 9, [2, 3]), ([0, 5], 3, [0, 3]), ([], 3, [])])
def test_shares_are_as_equal_as_can_be(available, goal, expected):
    assert shares(available, goal) == expected


def _rows(count, kind, generation, edge, seed):
    rows = np.zeros(count, row_type(1))
    rows["kind"], rows["generation"], rows["edge"] = kind, generation, edge
    rows["o"] = np.random.default_rng(seed).normal(size=(count, 3))
    return rows


def test_a_reservoir_keeps_every_stratum_of_a_long_stream():
    """A million primary rays do not crowd out ten reflections; of the stream all parts have the same chance."""
    reservoir = Reservoir(100)
    for wave in range(50):
        rows = _rows(1000, 0, 0, wave % 2 == 0, wave)
        rows["pixel"] = wave
        reservoir.offer(rows)
    reservoir.offer(_rows(10, 1, 3, True, 99))
    drawn = reservoir.draw(100)
    assert len(drawn) == 100
    assert drawn["edge"].sum() == 50 and (drawn["kind"] == KINDS.index("reflection")).sum() == 10
    assert len(np.unique(drawn["pixel"][drawn["kind"] == 0])) > 25  # of 50 waves, 90 draws
    assert len(reservoir.draw(10_000)) == 210


def test_where_nothing_is_an_edge_all_come_from_elsewhere():
    reservoir = Reservoir(100)
    reservoir.offer(_rows(500, 0, 0, False, 1))
    assert len(reservoir.draw(60)) == 60 and len(reservoir.draw(0)) == 0


def test_edges_are_where_objects_or_colours_change():
    index, color = np.zeros((6, 8), int), np.zeros((6, 8, 3))
    index[:, 4:] = 1  # a silhouette between columns 3 and 4
    color[3:, :, 1] = 0.5  # a shadow's edge between rows 2 and 3
    edge = edge_pixels(index, color)
    expected = np.zeros((6, 8), bool)
    expected[:, 3:5] = expected[2:4, :] = True
    np.testing.assert_array_equal(edge, expected)
