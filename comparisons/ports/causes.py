"""From wrong pixels to their causes: which mistakes of the catalogue, made together, show what pictures show.

Sets of mistakes are tried on a few hundred pixels, right and wrong ones: each alone, the figures' switches in all
combinations, then the best sets with one mistake more, less or other. What the best one leaves unexplained is looked at
again with more weight. The result is verified on a larger sample, and a mistake without which as much is explained is
dropped. Pixels whose right colour `mistaken.Tracers` misses itself are left out, and counted. Several pictures, and lists
of rays, of one program are one question: what looks like two mistakes on one scene looks like one of them on another.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace
from itertools import combinations

import numpy as np

from raytruth.reference_tracer.scene.model import Scene
from raytruth.reference_tracer.tracer.given_rays import GivenRays

from .mistaken import Exhausted, Tracers
from .mistakes import CATALOGUE, NOISY, SWITCHES, Mistakes, filed, moved, possible

SCREENED, VERIFIED = 150, 5000  # failing pixels on which sets are tried, on which the result is verified, at 1 sample each
OF_SEVERAL = 2  # times as many are tried of several pictures
BESIDE = 0.35  # as many of those that pass, which mistakes must leave as they are
BEAM = 3  # sets that go on from each round
NOISY_COST = 20  # mistakes: what has several draws matches some pixels by chance
MAPPED = 3000  # pixels on which maps of finished pixels are tried first
MOST_LOOKED_AT = 1 << 21  # pixels of a picture that is searched for specks
ROUNDS, LOOKS = 10, 4  # at most: rounds of one look, looks at what is left
ENOUGH = 0.99  # of the failing pixels explained: nothing else is looked for
NAMED = 0.5  # a cause that explains less than this is none
FAR, MISSED = 0.25, 0.15  # of a colour: differences that count alike; of a pixel: what the least difference counts
COST = 0.004  # of all pixels, that one more mistake has to explain
FEWEST = 2  # pixels that a mistake has to explain
ENGINE = 2e-4  # what `Tracers` leaves out of a colour, at most, see `least`
# that a search may follow, counted in place of seconds, so that every machine finds the same: of the mistakes in
# tests/ports/test_check_image.py, noise apart, the longest search follows 1.1 million
MOST_RAYS = 1_600_000


@dataclass(frozen=True)
class Causes:
    """`mistakes` made together explain `explained` of the `failing` pixels that were tried, and change `broken` of `passing`
    ones; `alternatives` are mistakes that alone explain as much as the one that is named."""

    mistakes: Mistakes
    explained: int
    failing: int
    broken: int
    passing: int
    left_out: int  # pixels that could not be traced well enough to be tried
    alternatives: tuple[str, ...] = ()
    shares: dict[str, float] = field(default_factory=dict)  # of the failing pixels that would be unexplained without each
    finished: bool = True  # whether the search came to its end within MOST_RAYS

    @property
    def share(self) -> float:
        return self.explained / self.failing if self.failing else 0.0

    @property
    def names(self) -> bool:
        return bool(self.mistakes) and self.share >= NAMED


@dataclass(frozen=True)
class Question:
    """A picture, or what rays meet, that fails: arrays are (h, w, channels) and (h, w), rays are those of a picture 1 high.

    The channels are colours, or, where `hits`, the distance and the normal of what is met first, as `Tracers.hits` has them
    (which way a normal points is told by the colours).
    """

    scene: Scene
    shown: np.ndarray  # as the file has it
    truth: np.ndarray
    failing: np.ndarray
    usable: np.ndarray  # pixels that can prove anything; the failing ones are among them
    levels: int | None  # of the file's whole numbers: 255, 65535; None of floats
    tolerance: float  # of the file
    literal: bool = False
    given: GivenRays | None = None
    hits: bool = False

    @property
    def samples(self) -> int:
        """Rays from the camera for a pixel."""
        return 1 if self.hits or self.given else self.scene.tracing.samples**2


def aligned(hits: np.ndarray, like: np.ndarray) -> np.ndarray:
    """`hits` (..., 4) with their normals turned as those of `like` are."""
    turn = (hits[..., 1:] * like[..., 1:]).sum(axis=-1, keepdims=True) < 0
    return np.concatenate([hits[..., :1], np.where(turn, -1, 1) * hits[..., 1:]], axis=-1)


def found(questions: Sequence[Question]) -> Causes:
    """Which mistakes one program has made that shows all this."""
    mapped = of_the_file(questions)
    return mapped if mapped else of_the_tracer(questions)


def of_the_file(questions: Sequence[Question]) -> Causes | None:
    """Mistakes that move or map finished pixels, tried on whole pictures: nothing has to be traced for them."""
    pictures = [q for q in questions if not q.given and not q.hits and q.failing.any()]
    if not pictures:
        return None
    ids = [id for id, m in _candidates(pictures).items() if m.stage == "file"]
    every = [np.flatnonzero(q.usable) for q in pictures]
    few = [np.random.default_rng(0).permutation(pixels)[:MAPPED // len(pictures)] for pixels in every]
    count = sum(map(len, every))

    def tried(chosen: tuple[str, ...], pixels: list[np.ndarray]) -> Causes:
        mistakes, join = dict.fromkeys(chosen, 1.0), lambda parts: np.concatenate(list(parts))
        shown = join(q.shown.reshape(-1, 3)[part] for q, part in zip(pictures, pixels))
        failing = join(q.failing.ravel()[part] for q, part in zip(pictures, pixels))
        color = join(q.truth[moved(mistakes, *np.divmod(part, q.failing.shape[1]), *q.failing.shape)]
                     for q, part in zip(pictures, pixels))
        tolerance = join(np.full(len(part), q.tolerance) for q, part in zip(pictures, pixels))
        if "scaled" in mistakes:
            mistakes["scaled"] = _factor(color, shown)
        with np.errstate(invalid="ignore"):
            same = np.abs(filed(mistakes, color, pictures[0].levels) - shown).max(axis=-1) <= tolerance
        return Causes(mistakes, int((same & failing).sum()), int(failing.sum()), int((~same & ~failing).sum()),
                      int((~failing).sum()), 0)

    best = None
    for size in (1, 2, 3):
        for chosen in combinations(ids, size):
            if sum(map(len, few)) < count and tried(chosen, few).share < NAMED:
                continue
            found = tried(chosen, every)
            if found.broken <= (1 - ENOUGH) * count and (best is None or found.explained > best.explained):
                best = found
        if best and best.share >= ENOUGH:
            return _of_samples(best, pictures)
    return None


def _of_samples(found: Causes, questions: Sequence[Question]) -> Causes:
    """A picture that is n times as bright as it should be at n x n samples has been divided by n instead of n^2."""
    n = questions[0].scene.tracing.samples
    if n == 1 or len(questions) > 1 or abs(found.mistakes.get("scaled", 0) - n) > 0.01 * n:
        return found
    return replace(found, mistakes={"divided-by-n" if id == "scaled" else id: a for id, a in found.mistakes.items()})


def _factor(color: np.ndarray, shown: np.ndarray) -> float:
    usable = (color > 0.1) & (shown > 0.02) & (shown < 0.98)
    return float(np.median(shown[usable] / color[usable])) if usable.any() else 1.0


def _candidates(questions: Sequence[Question]) -> dict:
    """What can show in one of these pictures, and in this kind of file."""
    shows = {id for q in questions for id in possible(q.scene)}
    # colours above 1 are clamped by files of whole numbers anyway
    shows -= {"clipped"} if questions[0].levels else {"truncated", "times-256", "wrapped"}
    if any(q.failing.shape[0] != q.failing.shape[1] for q in questions if not q.given):
        shows -= {"transposed"}
    return {id: m for id, m in CATALOGUE.items() if id in shows}


@dataclass
class _Budget:
    """How many rays may still be followed."""

    rays: int

    @property
    def spent(self) -> bool:
        return self.rays <= 0


class _Sample:
    """Some pixels of each question, and what sets of mistakes show there."""

    def __init__(self, questions: Sequence[Question], pixels: Sequence[np.ndarray], budget: _Budget):
        self.parts, self.budget = [(q, part) for q, part in zip(questions, pixels) if len(part)], budget
        join = lambda arrays: np.concatenate([*arrays, np.zeros(0)])
        self.failing = join(q.failing.ravel()[part] for q, part in self.parts).astype(bool)
        self.tolerance = join(np.full(len(part), q.tolerance + ENGINE * (1 if q.levels else 0.1)) for q, part in self.parts)
        self.levels = any(q.levels for q in questions)

    def differences(self, sets: list[Mistakes]) -> np.ndarray:
        """(sets, pixels): how far each is from what is shown, in its worst channel."""
        return np.concatenate([self._of_one(q, part, sets) for q, part in self.parts], axis=1)

    def _of_one(self, q: Question, pixels: np.ndarray, sets: list[Mistakes]) -> np.ndarray:
        expanded, owner = [], []
        for k, mistakes in enumerate(sets):
            draws = [mistakes]
            for id in NOISY:
                if id in mistakes:  # any draw of the noise will do, and none
                    draws = [{**mistakes, id: a} for a in CATALOGUE[id].amounts]
                    draws.append({i: a for i, a in mistakes.items() if i != id})
            expanded += draws
            owner += [k] * len(draws)
        found, shown = np.full((len(sets), len(pixels)), np.inf), q.shown.reshape(q.failing.size, -1)[pixels]
        rows, columns = np.divmod(pixels, q.failing.shape[1])
        most = max(1, 40_000 // (len(pixels) * q.samples))
        for start in range(0, len(expanded), most):
            part = expanded[start:start + most]
            tracers = Tracers(q.scene, part, q.literal, 1e-5 if q.levels else 1e-6, q.given)
            try:
                seen = (tracers.hits if q.hits else tracers.colors)(rows, columns)
            except Exhausted:
                continue
            finally:
                self.budget.rays -= tracers.rays
            for j, mistakes in enumerate(part):
                with np.errstate(invalid="ignore"):
                    there = aligned(seen[j], shown) if q.hits else filed(mistakes, seen[j], q.levels)
                    off = np.abs(there - shown).max(axis=-1)
                k = owner[start + j]
                found[k] = np.fmin(found[k], np.where(np.isfinite(off), off, np.inf))
        return found

    def losses(self, differences: np.ndarray, sets: list[Mistakes]) -> np.ndarray:
        # near misses count less: one of several mistakes brings most pixels nearer, and makes few of them equal
        near = np.sqrt(np.minimum(differences / FAR, 1))
        off = np.where(differences <= self.tolerance, 0.0, MISSED + (1 - MISSED) * near)
        return off.mean(axis=1) + COST * np.array([sum(NOISY_COST if id in NOISY else 1 for id in s) for s in sets])

    def matched(self, sets: list[Mistakes]) -> np.ndarray:
        return self.differences(sets) <= self.tolerance


def of_the_tracer(questions: Sequence[Question], seed: int = 0) -> Causes:
    """Which mistakes explain the failing pixels."""
    return _of_samples(_Search(questions, seed).causes(), questions)


def _specks(q: Question, most: int) -> np.ndarray:
    """Failing pixels that stand out most from their eight neighbours in the file itself, beyond what those differ among
    themselves."""
    height, width = q.failing.shape
    if q.failing.size > MOST_LOOKED_AT or min(height, width) < 3:
        return np.zeros(0, np.int64)
    grey = np.pad(q.shown.mean(axis=-1).astype(np.float32), 1, mode="edge")
    around = np.stack([grey[i:i + height, j:j + width] for i in range(3) for j in range(3)])
    own = around[4].copy()
    around.sort(axis=0)
    stands_out = np.where(q.failing, np.abs(own - around[4]) - (around[6] - around[2]), 0).ravel()
    chosen = np.argsort(-stands_out)[:most]
    return chosen[stands_out[chosen] > 2 * q.tolerance]


class _Search:
    def __init__(self, questions: Sequence[Question], seed: int):
        self.questions, self.random, self.budget = questions, np.random.default_rng(seed), _Budget(MOST_RAYS)
        self.candidates = _candidates(questions)
        pools, several = [], len(questions) > 1
        for q in questions:
            most = max(SCREENED, VERIFIED // q.samples) // len(questions)
            failing = self.random.permutation(np.flatnonzero(q.failing))
            chosen = failing[:most]
            if len(failing) > most and not several:  # a mistake that shows in few pixels would be missed by chance
                chosen = np.union1d(chosen, _specks(q, most // 8))
            passing = self.random.permutation(np.flatnonzero(q.usable & ~q.failing))[:int(BESIDE * most)]
            pools.append(np.concatenate([chosen, passing]))
        right = _Sample([replace(q, shown=q.truth, levels=None, tolerance=ENGINE) for q in questions], pools, self.budget)
        usable = right.matched([{}])[0] if right.parts else np.zeros(0, bool)
        self.left_out = int((~usable).sum())
        self.owner = np.repeat(np.arange(len(questions)), [len(pool) for pool in pools])[usable]
        self.pool = np.concatenate(pools)[usable]
        self.failing = right.failing[usable]
        rays = np.mean([questions[k].samples for k in self.owner]) if len(self.owner) else 1
        self.screened = max(40, min(SCREENED, int(2 * SCREENED / rays))) * (OF_SEVERAL if several else 1)

    def _sample(self, chosen: np.ndarray) -> _Sample:
        """Some of the pool, by their numbers, which come in ascending order."""
        return _Sample(self.questions, [self.pool[chosen[self.owner[chosen] == k]] for k in range(len(self.questions))],
                       self.budget)

    def causes(self) -> Causes:
        if not self.failing.any():
            return Causes({}, 0, 0, 0, 0, self.left_out)
        pool = self._sample(np.arange(len(self.pool)))
        sample = self._screen(np.zeros(len(self.pool), bool))
        seeds = [{}, *self._singles(), *self._switches()]
        best, singles = self._climb(sample, seeds)
        matched = pool.matched([best])[0]
        for _ in range(LOOKS - 1):
            left = pool.failing & ~matched
            if left.sum() < 2 or self.budget.spent:
                break
            if (matched & pool.failing).sum() >= ENOUGH * pool.failing.sum():  # what is left is rare: a switch, or nothing
                self.candidates = {id: m for id, m in self.candidates.items() if id in SWITCHES}
            better, _ = self._climb(self._screen(left | ~matched), [best, {}])
            again = pool.matched([better])[0]
            if again.sum() < matched.sum() + FEWEST * max(len(better) - len(best), 1):
                break
            best, matched = better, again
        best, matched, shares = self._without_idle(pool, best, matched)
        alternatives = ()
        if len(best) == 1:
            alternatives = self._alternatives(pool, best, matched, singles)
        return Causes(best, int((matched & pool.failing).sum()), int(pool.failing.sum()), int((~matched & ~pool.failing).sum()),
                      int((~pool.failing).sum()), self.left_out, alternatives, shares, not self.budget.spent)

    def _screen(self, stressed: np.ndarray) -> _Sample:
        """Pixels to try on: half of them, if there are that many, from those that are `stressed`."""
        failing = self.failing
        pick = lambda mask, most: self._evenly(self.random.permutation(np.flatnonzero(mask)))[:most]
        chosen = pick(stressed, self.screened // 2)
        rest = np.setdiff1d(np.arange(len(self.pool)), chosen)
        mask = np.zeros(len(self.pool), bool)
        mask[rest] = True
        chosen = np.concatenate([chosen, pick(mask & failing, self.screened - len(chosen)),
                                 pick(mask & ~failing, int(BESIDE * self.screened))])
        return self._sample(np.unique(chosen))

    def _evenly(self, chosen: np.ndarray) -> np.ndarray:
        """The same, the first of each question before the second of any."""
        turn, seen = np.empty(len(chosen), int), np.zeros(len(self.questions), int)
        for k, owner in enumerate(self.owner[chosen]):
            turn[k], seen[owner] = seen[owner], seen[owner] + 1
        return chosen[np.argsort(turn, kind="stable")]

    def _singles(self) -> list[Mistakes]:
        return [{id: a} for id, m in self.candidates.items() for a in (m.amounts if id not in NOISY else m.amounts[:1])]

    def _switches(self) -> list[Mistakes]:
        there = [id for id in SWITCHES if id in self.candidates]
        return [{id: CATALOGUE[id].amounts[0] for id in chosen}
                for size in range(2, len(there) + 1) for chosen in combinations(there, size)]

    def _climb(self, sample: _Sample, seeds: list[Mistakes]) -> tuple[Mistakes, list[tuple[float, Mistakes]]]:
        """The best set that is found from `seeds` on, and what they lose themselves."""
        seen: dict[tuple, float] = {}
        sets: dict[tuple, Mistakes] = {}

        def ask(asked: Iterable[Mistakes]) -> None:
            new = {key: s for s in asked if (key := tuple(sorted(s.items()))) not in seen}
            if not new:
                return
            chosen = list(new.values())
            differences = sample.differences(chosen)
            for key, s, loss in zip(new, chosen, sample.losses(differences, chosen)):
                seen[key], sets[key] = float(loss), s
            if () in new:
                self.base = differences[chosen.index({})]
            for s, off in zip(chosen, differences):
                if len(s) == 1 and hasattr(self, "base") and len(off) == len(self.base):
                    (id,) = s
                    moved_some = np.abs(off - self.base).max(initial=0, where=np.isfinite(off) & np.isfinite(self.base)) > 1e-9
                    self.idle[id] = self.idle.get(id, True) and not moved_some

        self.idle: dict[str, bool] = {}
        ask(seeds)
        singles = sorted(((loss, sets[key]) for key, loss in seen.items() if len(key) == 1), key=lambda pair: pair[0])
        beam, best = [], np.inf
        ask(self._fitted(sample, sets[key]) for key in sorted(seen, key=seen.get)[:BEAM])
        for _ in range(ROUNDS):
            beam = sorted(seen, key=seen.get)[:BEAM]
            if seen[beam[0]] > best - COST / 4 or seen[beam[0]] <= COST * (len(beam[0]) + 1) or self.budget.spent:
                break
            best = seen[beam[0]]
            ask(s for key in beam for s in self._neighbours(sets[key]))
        top = min(seen, key=seen.get)
        return self._fitted(sample, sets[top]), singles

    def _neighbours(self, mistakes: Mistakes) -> Iterable[Mistakes]:
        for id in mistakes:
            yield {i: a for i, a in mistakes.items() if i != id}
            if CATALOGUE[id].fitted:
                for factor in (0.7, 0.85, 1.2, 1.4):
                    yield {**mistakes, id: mistakes[id] * factor}
        for id, m in self.candidates.items():
            if id in mistakes or self.idle.get(id):
                continue
            for amount in m.amounts if id not in NOISY else m.amounts[:1]:
                yield {**mistakes, id: amount}

    def _fitted(self, sample: _Sample, mistakes: Mistakes) -> Mistakes:
        """The same mistakes, those that have a size with the one at which the picture differs least."""
        for id in [i for i in mistakes if CATALOGUE[i].fitted]:
            spread = 0.3
            while spread > 1e-7 and not self.budget.spent:
                tries = [{**mistakes, id: mistakes[id] * (1 + spread * k / 4)} for k in range(-4, 5)]
                near = np.maximum(3 * sample.tolerance, spread * 0.1)  # what is farther off has other causes
                loss = (np.minimum(sample.differences(tries), near)**2).mean(axis=1)
                mistakes = tries[int(loss.argmin())]
                if sample.levels and spread < 1e-4:
                    break
                spread /= 3
        return mistakes

    def _without_idle(self, pool: _Sample, mistakes: Mistakes, matched: np.ndarray):
        """Only those mistakes without which less is explained, and how much less."""
        while mistakes:
            fewer = [{i: a for i, a in mistakes.items() if i != id} for id in mistakes]
            others = pool.matched(fewer)
            lost = matched.sum() - others.sum(axis=1)
            k = int(lost.argmin())
            if lost[k] >= (FEWEST if list(mistakes)[k] not in NOISY else 0.05 * pool.failing.sum()):
                failing = max(int(pool.failing.sum()), 1)
                return mistakes, matched, {id: float(n) / failing for id, n in zip(mistakes, lost)}
            mistakes, matched = fewer[k], others[k]
        return mistakes, matched, {}

    def _alternatives(self, pool: _Sample, best: Mistakes, matched: np.ndarray, singles) -> tuple[str, ...]:
        close = [s for loss, s in singles[:6] if set(s) != set(best)]
        if not close:
            return ()
        others = pool.matched(close)
        return tuple(dict.fromkeys(id for s, o in zip(close, others) for id in s if o.sum() >= matched.sum() - 1))
