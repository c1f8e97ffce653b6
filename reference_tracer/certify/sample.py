"""Samples that every kind of ray is in: pixels on edges, and a reservoir with a share for every stratum."""

from __future__ import annotations

import numpy as np

COLOUR_JUMP = 0.05  # between neighbouring pixels, in linear colour; a shadow's edge is one


def edge_pixels(index: np.ndarray, color: np.ndarray) -> np.ndarray:
    """(h, w) pixels beside which another object begins or the colour jumps: silhouettes and shadow edges."""
    edge = np.zeros(index.shape, bool)
    for axis in (0, 1):
        here, there = [slice(None)] * 2, [slice(None)] * 2
        here[axis], there[axis] = slice(None, -1), slice(1, None)
        here, there = tuple(here), tuple(there)
        jumps = (index[here] != index[there]) | (np.abs(color[here] - color[there]).max(axis=-1) > COLOUR_JUMP)
        edge[here] |= jumps
        edge[there] |= jumps
    return edge


class Reservoir:
    """Keeps up to `room` random rows of every stratum (kind, generation, edge) of a stream of unknown length."""

    def __init__(self, room: int, seed: int = 1):
        self.room, self.random = room, np.random.default_rng(seed)
        self.kept: dict[tuple, tuple[np.ndarray, np.ndarray]] = {}  # stratum -> (keys, rows), smallest keys win

    def offer(self, rows: np.ndarray) -> None:
        """`rows` are of one kind and generation each, in any mixture."""
        strata = rows["kind"].astype(int) * 512 + rows["generation"].astype(int) * 2 + rows["edge"]
        for stratum in np.unique(strata):
            own = np.flatnonzero(strata == stratum)
            keys = self.random.random(len(own))
            best = np.argsort(keys)[:self.room]
            self._merge(int(stratum), keys[best], rows[own[best]])

    def _merge(self, stratum: int, keys, rows) -> None:
        if stratum in self.kept:
            keys, rows = (np.concatenate(pair) for pair in zip(self.kept[stratum], (keys, rows)))
            best = np.argsort(keys)[:self.room]
            keys, rows = keys[best], rows[best]
        self.kept[stratum] = keys, rows

    def draw(self, count: int) -> np.ndarray:
        """About `count` rows: half of them at edges if there are enough, the strata of either half in equal shares."""
        halves = [[rows for stratum, (_, rows) in sorted(self.kept.items()) if stratum % 2 == edge] for edge in (1, 0)]
        available = [sum(map(len, half)) for half in halves]
        at_edges = max(min(available[0], count // 2), min(available[0], count - available[1]))
        drawn = [rows[:share] for half, goal in zip(halves, (at_edges, count - at_edges))
                 for rows, share in zip(half, shares([len(rows) for rows in half], goal))]
        return np.concatenate(drawn) if drawn else np.empty(0)


def shares(available: list[int], goal: int) -> list[int]:
    """How many to take of each so that they sum to `goal`, as equal as what is available allows."""
    taken = [0] * len(available)
    left = min(goal, sum(available))
    while left:
        open_ones = [k for k, n in enumerate(available) if taken[k] < n]
        for place, k in enumerate(open_ones):
            wanted = -(-left // (len(open_ones) - place))
            more = min(wanted, available[k] - taken[k])
            taken[k] += more
            left -= more
    return taken
