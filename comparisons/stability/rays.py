"""The rays of a case: where they run, what is known of them, and the exact answer."""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np


@dataclass
class Rays:
    """n rays o + t d on (0, limit], the numbers f takes for each of them, and the truth. Arrays of length n, fp64.

    `first` is the exact distance of the first change of side: infinity where there is none, NaN where f is undefined
    on the way, so that the only right answer is "undecided" (decision M7). `others` are further roots on the line.
    """

    o: np.ndarray  # (n, 3)
    d: np.ndarray  # (n, 3)
    inside: np.ndarray  # bool, the side each ray starts on
    limit: np.ndarray
    first: np.ndarray
    others: np.ndarray  # (n, k), infinity where there are fewer
    accuracy: np.ndarray  # |t - first| up to this is correct
    step: np.ndarray  # stepSize of the literal method
    reach: np.ndarray  # where the literal method stops; the others go to `limit`
    parameters: dict[str, np.ndarray]

    @staticmethod
    def of(o, d, *, first, inside=False, limit=6.0, others=None, accuracy=1e-6, step=0.05, reach=None,
           **parameters) -> Rays:
        """Rays from arrays or from single numbers that hold for all of them."""
        n = len(o)
        wide = lambda v, kind=float: np.array(np.broadcast_to(np.asarray(v, kind), (n,)))
        others = np.full((n, 0), np.inf) if others is None else np.reshape(np.asarray(others, float), (n, -1))
        return Rays(np.asarray(o, float), np.asarray(d, float), wide(inside, bool), wide(limit), wide(first), others,
                    wide(accuracy), wide(step), wide(limit if reach is None else reach),
                    {name: wide(v) for name, v in parameters.items()})

    def __len__(self):
        return len(self.o)

    @staticmethod
    def joined(parts: list[Rays]) -> Rays:
        """One batch of all the rays of `parts`, which take the same parameters."""
        most = max(part.others.shape[1] for part in parts)
        join = {}
        for field in fields(Rays):
            values = [getattr(part, field.name) for part in parts]
            if field.name == "others":
                values = [np.pad(v, ((0, 0), (0, most - v.shape[1])), constant_values=np.inf) for v in values]
            if field.name != "parameters":
                join[field.name] = np.concatenate(values)
        names = parts[0].parameters
        return Rays(**join, parameters={k: np.concatenate([part.parameters[k] for part in parts]) for k in names})


@dataclass
class Draw:
    """A source of random rays: how many, from which generator, in which precision they are stored."""

    count: int
    random: np.random.Generator
    precision: int

    @property
    def single(self) -> bool:
        return self.precision == 32

    def stored(self, v) -> np.ndarray:
        """`v` rounded to the precision under test, so that the exact answer is that of the rays as they are."""
        return np.asarray(v, np.float32).astype(float) if self.single else np.asarray(v, float)

    def uniform(self, low: float, high: float, shape=()) -> np.ndarray:
        return self.random.uniform(low, high, (self.count, *shape))

    def directions(self) -> np.ndarray:
        """Unit vectors without a preferred direction, (count, 3)."""
        return unit(self.random.normal(size=(self.count, 3)))

    def lines(self, impact, distance: float, jitter: float) -> tuple[np.ndarray, np.ndarray]:
        """(o, d) of lines that pass the origin at distance `impact`, from `distance` before their nearest point.

        The start is moved by up to `jitter`, so that the phase of fixed steps is uniform if jitter is a multiple of
        the step.
        """
        d = self.directions()
        across = unit(np.cross(d, self.directions()))
        along = self.uniform(0, jitter) - distance
        return self.stored(across * np.reshape(impact, (-1, 1)) + d * along[:, None]), self.stored(d)

    def along_x(self, start: float, jitter: float, sign: float = 1.0) -> tuple[np.ndarray, np.ndarray]:
        """(o, d) of rays along the x axis that start at x = start - sign U(0, jitter), with y and z at random."""
        o = self.uniform(-1, 1, (3,))
        o[:, 0] = start - sign * self.uniform(0, jitter)
        return self.stored(o), np.tile([sign, 0.0, 0.0], (self.count, 1))


def unit(v) -> np.ndarray:
    return v / np.linalg.norm(v, axis=-1, keepdims=True)
