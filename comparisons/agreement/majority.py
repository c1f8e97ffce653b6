"""The odd one out, by majority of independent implementations.

Renderers that share their shading are wrong together, so each implementation has one vote: what speaks against a
renderer is, for every implementation, the share of its other renderers that disagree with it. The one that most speaks
against leaves, until all that are left agree. Where two are equally suspect nobody can say which is wrong.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

EQUAL = 1e-9  # votes are sums of fractions


@dataclass(frozen=True)
class Odd:
    """`suspects` is one renderer, or several of which at least one is wrong; `against` are those they disagree with."""

    suspects: tuple[str, ...]
    against: tuple[str, ...]


def odd_ones(implementation: dict[str, str], disagree: Iterable[tuple[str, str]]) -> list[Odd]:
    """Who disagrees with the majority, most suspect first.

    `implementation` maps every renderer that has a picture to what it is built on; `disagree` are the pairs whose
    limits are exceeded. A pair that was not compared counts as agreeing.
    """
    left, pairs = list(implementation), {frozenset(pair) for pair in disagree}
    found = []
    while True:
        votes = {name: _votes(name, left, implementation, pairs) for name in left}
        most = max(votes.values(), default=0)
        if most <= EQUAL:
            return found
        suspects = [name for name in left if votes[name] >= most - EQUAL]
        against = [name for name in left if any(frozenset((name, s)) in pairs for s in suspects if s != name)]
        if len(suspects) > 1:
            # renderers of one implementation that everybody else contradicts together are wrong together
            if len({implementation[s] for s in suspects}) > 1 or any(
                    frozenset((a, b)) in pairs for a in suspects for b in suspects if a != b):
                return [*found, Odd(tuple(suspects), tuple(against))]
        for suspect in suspects:
            found.append(Odd((suspect,), tuple(n for n in left if frozenset((n, suspect)) in pairs)))
        left = [name for name in left if name not in suspects]


def _votes(name: str, left: list[str], implementation: dict[str, str], pairs: set[frozenset]) -> float:
    votes = 0.0
    for built_on in set(implementation.values()):
        others = [n for n in left if n != name and implementation[n] == built_on]
        if others:
            votes += sum(frozenset((name, n)) in pairs for n in others) / len(others)
    return votes
