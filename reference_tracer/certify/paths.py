"""Whole pixel paths: the picture held against its 77-digit recomputation."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable

import numpy as np

from ..tracer.render import Picture
from .certificate import PathErrors
from .precise import BITS, Critical, Path, PreciseTracer
from .records import KINDS
from .sample import shares
from .search import precision

MOST_TESTS = 60_000  # rays times objects that the high-precision tracer may take on for a scene
NUDGES = tuple(sign * size for size in (2e-16, 1e-14, 1e-12) for sign in (1, -1))  # radians
CANDIDATES = 4  # pixels watched for each path wanted: some will not be proven, some cost too much


def candidates(picture: Picture, edges: np.ndarray, count: int, seed: int = 2) -> np.ndarray:
    """Pixels (flat numbers) whose paths may be recomputed: half at edges, every depth of recursion in equal shares."""
    random, chosen = np.random.default_rng(seed), []
    depth, edge = picture.depth.ravel(), edges.ravel()
    for at_edge, goal in ((True, count // 2), (False, count - count // 2)):
        strata = [random.permutation(np.flatnonzero((edge == at_edge) & (depth == k)))
                  for k in np.unique(depth[edge == at_edge])]
        chosen += [pixels[:share] for pixels, share in zip(strata, shares([len(s) for s in strata], goal))]
    return random.permutation(np.concatenate(chosen)) if chosen else np.empty(0, np.int64)


def compare_paths(picture: Picture, pixels: np.ndarray, count: int, census,
                  progress: Callable[[float], None] = lambda share: None) -> PathErrors:
    """Recomputes up to `count` of `pixels` whose every ray is proven; `census` knows their rays and decisions."""
    result, width = PathErrors(), picture.scene.camera.width
    proven = [int(p) for p in pixels if census.proven_pixel[p]]
    budget, objects = MOST_TESTS, len(picture.scene.objects)
    tracer, skipped = PreciseTracer(picture.scene), 0
    for pixel in proven:
        if result.paths >= count:
            break
        cost = int(census.rays_of_pixel[pixel]) * objects
        if cost > budget:
            skipped += 1
            continue
        budget -= cost
        result.paths += 1
        _compare(result, tracer, picture, divmod(pixel, width), census.decisions[pixel])
        progress(result.paths / count)
    if result.paths < count:
        result.not_tried = (f"{len(pixels)} pixels drawn, {len(pixels) - len(proven)} of them not proven along their "
                            f"whole path, {skipped} too long")
    return result


def _compare(result: PathErrors, tracer: PreciseTracer, picture: Picture, place, decisions: Counter) -> None:
    row, col = place
    where = f"pixel ({row}, {col})"
    try:
        path = tracer.pixel(row, col)
    except Critical as reason:
        result.near_critical.append(f"{where}: {reason}")
        return
    result.rays += path.rays
    result.deepest = max(result.deepest, int(picture.depth[row, col]))
    with precision(BITS):
        error = max(float(abs(exact - float(ours))) for exact, ours in zip(path.color, picture.color[row, col]))
    if path.decisions == decisions:
        result.largest_error = max(result.largest_error, error)
        result.above_bar += error > result.bar
        return
    text = f"{where}: {_difference(path.decisions, decisions)}; colours differ by {error:.1e}"
    (result.near_critical if _wavers(tracer, path, place) else result.wrong).append(text)


def _wavers(tracer: PreciseTracer, path: Path, place) -> bool:
    """Whether a turn of the camera's rays by rounding or little more changes decisions of the path."""
    for nudge in NUDGES:
        try:
            if tracer.pixel(*place, nudge).decisions != path.decisions:
                return True
        except Critical:
            return True
    return False


def _difference(exact: Counter, ours: Counter) -> str:
    first = min((exact - ours) + (ours - exact), key=lambda d: d.generation)
    return f"a {KINDS[first.kind]} ray of generation {first.generation} is decided otherwise"
