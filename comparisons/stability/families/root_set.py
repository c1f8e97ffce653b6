"""The fifteen functions of Alefeld, Potra and Shi, as surfaces f(x, y, z) = 0 that depend on x alone.

G. E. Alefeld, F. A. Potra, Y. Shi: Algorithm 748: Enclosing zeros of continuous functions. ACM Transactions on
Mathematical Software 21 (1995) 327-344, table I. Where the table varies an exponent n, one n is taken (an exponent is
part of a kernel); other parameters run through the table's values, drawn at random for every ray.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from raytruth.reference_tracer.numbers import functions as fn

from ..exact import root_between
from ..family import About, Draw, Outcome, Rays, Shape
from ..methods import Method

ACCURACY = 1e-9
STEPS = 20  # of the literal method on the interval of the table

Piece = tuple[Callable, Callable]  # f(x, **parameters), and its interval as a function of the parameters


@dataclass(frozen=True)
class Problem:
    """One row of the table. `root_of` is the piece of f that holds the root, where f itself is made of pieces."""

    text: str
    f: Callable
    interval: Callable  # parameters -> (a, b)
    choices: tuple[dict, ...] = ({},)
    degree: int | None = None
    root_of: Piece | None = None
    in_f: tuple[str, ...] | None = None  # the parameters f takes; None: all

    @property
    def shape(self) -> Shape:
        return Shape(lambda x, y, z, **parameters: self.f(x, **parameters), degree=self.degree)

    def parameters(self, choice: dict) -> dict:
        return {k: float(v) for k, v in choice.items() if self.in_f is None or k in self.in_f}

    def root(self, choice: dict) -> float:
        f, interval = self.root_of or (self.f, self.interval)
        return root_between(lambda x: f(x, **self.parameters(choice)), *interval(**choice))

    def rays(self, draw: Draw) -> Rays:
        """Rays along x from anywhere in the first nine tenths between the interval's start and the root."""
        which = draw.random.integers(0, len(self.choices), draw.count)
        ends = np.array([self.interval(**choice) for choice in self.choices])[which]
        root = np.array([self.root(choice) for choice in self.choices])[which]
        inside = np.array([bool(self.f(self.interval(**c)[0], **self.parameters(c)) < 0) for c in self.choices])[which]
        o = draw.uniform(-1, 1, (3,))
        o[:, 0] = ends[:, 0] + draw.uniform(0, 0.9) * (root - ends[:, 0])
        parameters = [self.parameters(choice) for choice in self.choices]
        return Rays.of(o, np.tile([1.0, 0, 0], (len(o), 1)), inside=inside, limit=ends[:, 1] - o[:, 0],
                       first=root - o[:, 0], accuracy=ACCURACY, step=(ends[:, 1] - ends[:, 0]) / STEPS,
                       **{k: np.array([p[k] for p in parameters])[which] for k in parameters[0]})


def _between(a: float, b: float):
    return lambda **_: (a, b)


def _n(*values: int) -> tuple[dict, ...]:
    return tuple({"n": float(n)} for n in values)


def _poles(x):
    return sum(((2 * i - 5) ** 2 / (x - i * i) ** 3 for i in range(2, 21)), 9.0 / (x - 1) ** 3) * -2.0


def _ramp(x, n):
    return (x * (1 / 1.5) + fn.sin(x) - 1) * (n * 0.05)


def _step(x, n):
    return fn.exp(x * ((n + 1) * 500)) - 1.859


PROBLEMS = (
    Problem("sin x - x/2", lambda x: fn.sin(x) - x / 2, _between(math.pi / 2, math.pi)),
    Problem("-2 sum (2i - 5)^2 / (x - i^2)^3 between two poles", _poles,
            lambda n: (n * n + 1e-9, (n + 1) ** 2 - 1e-9), _n(*range(1, 11)), in_f=()),
    Problem("a x exp(b x)", lambda x, a, b: x * fn.exp(x * b) * a, _between(-9, 31),
            tuple({"a": a, "b": b} for a, b in ((-40, -1), (-100, -2), (-200, -3)))),
    Problem("x^12 - a", lambda x, a: x**12 - a, lambda a, low: (low, low + 5),
            ({"a": 0.2, "low": 0.0}, {"a": 1.0, "low": 0.0}, {"a": 1.0, "low": -0.95}), degree=12, in_f=("a",)),
    Problem("sin x - 1/2", lambda x: fn.sin(x) - 0.5, _between(0, 1.5)),
    Problem("2 x exp(-n) - 2 exp(-n x) + 1", lambda x, n: x * (fn.exp(-n) * 2) - fn.exp(x * -n) * 2 + 1,
            _between(0, 1), _n(1, 2, 3, 4, 5, 20, 40, 60, 80, 100)),
    Problem("(1 + (1 - n)^2) x - (1 - n x)^2", lambda x, n: x * (1 + (1 - n) ** 2) - (x * n - 1) ** 2,
            _between(0, 1), _n(5, 10, 20), degree=2),
    Problem("x^2 - (1 - x)^10", lambda x: x**2 - (x - 1) ** 10, _between(0, 1), degree=10),
    Problem("(1 + (1 - n)^4) x - (1 - n x)^4", lambda x, n: x * (1 + (1 - n) ** 4) - (x * n - 1) ** 4,
            _between(0, 1), _n(1, 2, 4, 5, 8, 15, 20), degree=4),
    Problem("exp(-10 x) (x - 1) + x^10", lambda x: fn.exp(x * -10.0) * (x - 1) + x**10, _between(0, 1)),
    Problem("(n x - 1) / ((n - 1) x)", lambda x, n: (x * n - 1) / (x * (n - 1)), _between(0.01, 1), _n(2, 5, 15, 20)),
    Problem("x^(1/n) - n^(1/n)", lambda x, n, root: fn.exp(fn.log(x) * (1 / n)) - root, _between(1, 100),
            tuple({"n": n, "root": n ** (1 / n)} for n in (2, 3, 4, 5, 6, *range(7, 34, 2)))),
    Problem("x exp(-1/x^2)", lambda x: x * fn.exp(-1 / x**2), _between(-1, 4)),
    Problem("n/20 (x/1.5 + sin x - 1), constant below 0", lambda x, n: _ramp(fn.maximum(x, 0.0), n),
            _between(-1e4, math.pi / 2), _n(*range(1, 41)), root_of=(_ramp, _between(0, math.pi / 2))),
    Problem("exp((n + 1) x 500) - 1.859, constant outside of [0, 0.002/(1 + n)]",
            lambda x, n: _step(fn.minimum(fn.maximum(x, 0.0), 0.002 / (n + 1)), n), _between(-1e4, 1e-4),
            _n(*range(20, 41), *range(100, 1001, 100)), root_of=(_step, lambda n: (0.0, 0.002 / (1 + n)))))


@dataclass(frozen=True)
class RootSet:
    """Every problem is a value of p, with an f of its own."""

    about: About
    laws: tuple = ()
    variants: tuple = ()

    def cases(self, precision: int, count: int) -> list[Rays]:
        return [problem.rays(draw) for (_, draw), problem in zip(self.about.draws(precision, count), PROBLEMS)]

    def run(self, cases: list[Rays], method: Method, precision: int) -> list[Outcome | None] | None:
        outcomes = [problem.shape.run([rays], method, precision) for problem, rays in zip(PROBLEMS, cases)]
        return [outcome[0] if outcome else None for outcome in outcomes] if any(outcomes) else None


FAMILIES = (
    RootSet(About(
        "root-set", "The root-finding problems of Alefeld, Potra and Shi", "number of the problem",
        tuple(float(k) for k in range(1, len(PROBLEMS) + 1)), labels=tuple(problem.text for problem in PROBLEMS),
        when="The curve bends, is flat or has poles within the step in which the root lies.",
        why="Newton from the middle of a step trusts the tangent there; it was made for starting near the root. "
            "Problem 13 is flat to all orders: f is zero in fp64 for |x| < 0.036, and no sign is left to find.",
        instead="Newton that keeps its bracket; proofs where f itself loses its sign.")),)
