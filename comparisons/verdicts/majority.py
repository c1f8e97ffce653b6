"""The odd one out, by majority of independent implementations.

Renderers that share their shading are wrong together, so each implementation has one vote: what speaks against a
renderer is, for every implementation, the share of its other renderers that disagree with it. Those that most speaks
against leave if that is more than half of all votes, and so on until all that are left agree. Without such a majority, or
where more implementations are suspect than not, nobody can say which is wrong.
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


def odd_ones(implementation: dict[str, str], disagree: Iterable[tuple[str, str]], known: str = "") -> list[Odd]:
    """Who disagrees with the majority, most suspect first.

    `implementation` maps every renderer that has a picture to what it is built on; `disagree` are the pairs whose
    limits are exceeded. A pair that was not compared counts as agreeing. Where there is no majority it is `known`, if
    that is among those who disagree: the one whose faults are its nature.
    """
    left, pairs = list(implementation), {frozenset(pair) for pair in disagree}
    found = []
    while True:
        against = {name: tuple(n for n in left if frozenset((n, name)) in pairs) for name in left}
        shares = {name: _share(name, left, implementation, against[name]) for name in left}
        most = max(shares.values(), default=0)
        if most <= EQUAL:
            return found
        suspects = [name for name in left if shares[name] >= most - EQUAL]
        trusted = {implementation[name] for name in left if name not in suspects}
        if most <= 0.5 + EQUAL or len(trusted) <= len({implementation[s] for s in suspects}):
            suspects = [name for name in left if name in suspects or any(name in against[s] for s in suspects)]
            if known not in suspects:
                return [*found, Odd(tuple(suspects), tuple(n for n in left if any(n in against[s] for s in suspects)))]
            suspects = [known]
        found += [Odd((s,), against[s]) for s in suspects]
        left = [name for name in left if name not in suspects]


def _share(name: str, left: list[str], implementation: dict[str, str], against: tuple[str, ...]) -> float:
    """The share of all votes that speaks against a renderer; other renderers of its implementation have one as well."""
    votes = []
    for built_on in {implementation[n] for n in left}:
        others = [n for n in left if n != name and implementation[n] == built_on]
        if others:
            votes.append(sum(n in against for n in others) / len(others))
    return sum(votes) / len(votes) if votes else 0.0
