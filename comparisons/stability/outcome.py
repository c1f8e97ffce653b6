"""The kinds of answers a method can give, and how an answer is held against the exact one."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .rays import Rays

MOST_EVALUATIONS = 10_000  # of f for one ray; the literal method spends 600 on a range of 30 with steps of 0.05

KINDS = {
    "correct": "the exact answer",
    "missed": "the ray crosses the surface, and nothing was reported",
    "false": "a crossing was reported where there is none, or an answer was given where f is undefined",
    "wrong root": "another root on the ray was reported in place of the first crossing",
    "diverged": "a point was reported that is no root at all",
    "non-finite": "the distance reported is infinite or not a number",
    "wrong value": "a colour or a direction is off by more than the stated accuracy",
    "undecided": "the method says itself that it does not know",
    "too slow": f"right, but with more than {MOST_EVALUATIONS} evaluations of f for one ray"}
NAMES = tuple(KINDS)
CODE = {name: code for code, name in enumerate(NAMES)}
WRONG = ("missed", "false", "wrong root", "diverged", "non-finite", "wrong value")  # and not flagged


@dataclass
class Answer:
    """What a method says of n rays, as NumPy arrays of length n."""

    found: np.ndarray  # bool
    t: np.ndarray  # fp64, meaningful where found
    undecided: np.ndarray  # bool
    evaluations: np.ndarray  # of f


def classify(rays: Rays, answer: Answer) -> np.ndarray:
    """The kind of every answer as an index into NAMES, (n,).

    A flag "undecided" comes first: such an answer claims nothing. Where f is undefined on the way (decision M7) it is
    the only correct answer.
    """
    crosses, undefined = np.isfinite(rays.first), np.isnan(rays.first)
    with np.errstate(invalid="ignore"):
        near = np.abs(answer.t - rays.first) <= rays.accuracy
        elsewhere = np.any(np.abs(answer.t[:, None] - rays.others) <= rays.accuracy[:, None], axis=1)
    off = crosses & answer.found & ~near
    kind = np.full(len(answer.t), CODE["correct"])
    for name, where in (("too slow", answer.evaluations > MOST_EVALUATIONS),
                        ("missed", crosses & ~answer.found),
                        ("false", (~crosses & answer.found) | undefined),
                        ("wrong root", off & elsewhere),
                        ("diverged", off & ~elsewhere),
                        ("non-finite", answer.found & ~np.isfinite(answer.t)),
                        ("undecided", answer.undecided & ~undefined),
                        ("correct", answer.undecided & undefined)):
        kind[where] = CODE[name]
    return kind
