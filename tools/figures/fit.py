"""Fits numbers of a scene to a picture by least squares, on pixels away from edges.

Edges are where either picture changes faster than light on a smooth surface does: silhouettes, borders of shadows, rims of
mirror images. There a pixel's colour jumps with the numbers, so that its difference tells nothing of how to change them.
The picture is first compared blurred and coarse, so that a wrong start finds its way, then pixel by pixel.
"""

from __future__ import annotations

import json
import math
import re
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.ndimage import maximum_filter, minimum_filter
from scipy.optimize import least_squares

from raytruth.reference_tracer.errors import InputError
from raytruth.reference_tracer.scene.load import parse_scene
from raytruth.reference_tracer.scene.model import Scene
from raytruth.reference_tracer.tracer.render import Renderer

from .pixels import METHOD, colors

PIXELS = 3000  # that a fit looks at: some hundreds a number are enough
MOST_BLOCK = 16  # pixels a side of the coarsest blocks; then a quarter of it, then pixels
EDGE = 12  # grey levels among a pixel's neighbours, from which on one of them may lie beyond an edge
SAMPLES = 4  # n x n of a block: its mean is compared, not its centre
STEP = 1e-5  # of a number, or of 1 if it is smaller, for derivatives: far above what fp64 rounds, far below a grey level
STRIDE = 1e-3  # the same for blocks, times their side: edges have to pass samples, or nothing tells how they move
REACH = 4  # grey levels: what differs by more is of an edge that was missed, and does not count as noise
ROUNDS = 3  # of the last pass: the edges are found anew with the numbers so far
JUMP = 1  # grey levels: what changes by more over a step has jumped from one object to another
SEED = 1
_STEP = re.compile(r"([A-Za-z_]+)|\[(\d+)\]|\.")


@dataclass(frozen=True)
class Fit:
    """What was found: the scene, and for every number its name, value and standard error; residuals in grey levels."""

    scene: Scene
    names: list[str]
    values: np.ndarray
    errors: np.ndarray  # standard errors, from the residuals and their derivatives
    median: float  # of the absolute residuals
    rms: float  # of the residuals within the robust loss's reach
    pixels: int  # compared


class Numbers:
    """The free numbers of a scene file, as one vector. A list is all its numbers; `a=b` ties two paths."""

    def __init__(self, scene: Scene, free: list[str]):
        self.document = scene.model_dump(mode="json", by_alias=True, exclude_none=True)
        self.places = [place for path in free for place in self._leaves(path)]
        self.names = [names[0] for names, _ in self.places]
        self.start = np.array([float(self._at(steps[0])) for _, steps in self.places])

    def _leaves(self, path: str):
        tied = [_steps(p) for p in path.split("=")]
        value = self._at(tied[0])
        if isinstance(value, list):
            return [([_written(s + [k]) for s in tied], [s + [k] for s in tied]) for k in range(len(value))]
        if isinstance(value, bool) or not isinstance(value, (int, float)):
            raise InputError(f"--free {path}: is not a number or a list of numbers of the scene")
        return [([_written(s) for s in tied], tied)]

    def _at(self, steps):
        value = self.document
        try:
            for step in steps:
                value = value[step]
        except (KeyError, IndexError, TypeError):
            raise InputError(f"--free {_written(steps)}: is not in the scene") from None
        return value

    def scene(self, values: np.ndarray) -> Scene:
        """The scene with these numbers. Raises InputError if it is none."""
        document = json.loads(json.dumps(self.document))
        for (_, places), value in zip(self.places, values):
            for steps in places:
                at = document
                for step in steps[:-1]:
                    at = at[step]
                at[steps[-1]] = float(value)
        return parse_scene(json.dumps(document).encode(), "fitted scene")


def _steps(path: str) -> list:
    found = [m.group(1) or (int(m.group(2)) if m.group(2) else None) for m in _STEP.finditer(path)]
    if "".join(m.group(0) for m in _STEP.finditer(path)) != path or not path:
        raise InputError(f"--free {path}: must read like camera.fov or lights[0].position")
    return [step for step in found if step is not None]


def _written(steps) -> str:
    return "".join(f"[{s}]" if isinstance(s, int) else f".{s}" for s in steps).lstrip(".")


def fit(scene: Scene, picture: np.ndarray, free: list[str], pixels: int = PIXELS,
        tell: Callable[[str], None] = lambda text: None) -> Fit:
    """`scene` with the `free` numbers fitted to the 8-bit `picture` (h, w, 3), which has the size of its camera.

    `tell` is given a line after each pass. Raises InputError for paths that name no number and for a picture of another size.
    """
    camera = scene.camera
    if picture.shape[:2] != (camera.height, camera.width):
        raise InputError(f"the picture has {picture.shape[1]} x {picture.shape[0]} pixels, the scene's camera {camera.width} x "
                         f"{camera.height}; they must be the same")
    numbers = Numbers(scene, free)
    values, random = numbers.start, np.random.default_rng(SEED)
    for block in _blocks(camera.width, camera.height):
        blurred = picture.reshape(camera.height // block, block, camera.width // block, block, 3).mean(axis=(1, 3))
        for _ in range(ROUNDS if block == 1 else 1):
            chosen = _chosen(numbers.scene(values), blurred, block, pixels, random)
            solved = _solved(numbers, values, blurred.reshape(-1, 3)[chosen], chosen, block)
            values = solved.x
            tell(f"blocks of {block}, {len(chosen)} of them: median {np.median(np.abs(solved.fun)):.3f} grey levels; "
                 + ", ".join(f"{name} {value:.6g}" for name, value in zip(numbers.names, values)))
    noise = np.sqrt(np.mean(solved.fun[np.abs(solved.fun) <= REACH]**2))
    jacobian = solved.jac[np.abs(solved.fun) <= REACH]
    errors = noise * np.sqrt(np.maximum(np.diag(np.linalg.pinv(jacobian.T @ jacobian)), 0))
    return Fit(numbers.scene(values), numbers.names, values, errors, float(np.median(np.abs(solved.fun))), float(noise),
               len(chosen))


def _blocks(width: int, height: int) -> list[int]:
    """Pixels a side of the blocks of each pass; blocks fill the picture."""
    divisors = [k for k in range(1, MOST_BLOCK + 1) if math.gcd(width, height) % k == 0]
    return sorted({divisors[-1], max(k for k in divisors if 4 * k <= max(4, divisors[-1])), 1}, reverse=True)


def _chosen(scene: Scene, picture: np.ndarray, block: int, most: int, random) -> np.ndarray:
    """Numbers in row order of the blocks to compare: any, but single pixels lie off the edges of both pictures."""
    height, width = picture.shape[:2]
    if block > 1:
        return np.sort(random.permutation(height * width)[:most])
    there = np.zeros((height, width), bool)
    there[1:-1, 1:-1] = _spread(picture, 3)[1:-1, 1:-1] < EDGE
    candidates = random.permutation(np.flatnonzero(there))[:2 * most]
    if not len(candidates):
        raise InputError("the picture has no pixel away from an edge")
    around = candidates[:, None] + np.array([0, -1, 1, -width, width])
    seen = 255 * colors(scene.traced_with(samples=1), around.ravel()).reshape(-1, 5, 3).clip(0, 1)
    lit = picture.reshape(-1, 3)[candidates].max(axis=1) + seen[:, 0].max(axis=1) > 0  # black in both tells nothing
    calm = (seen.max(axis=1) - seen.min(axis=1)).max(axis=1) < EDGE
    return np.sort(candidates[calm & lit][:most])


def _spread(picture: np.ndarray, size: int) -> np.ndarray:
    """The range (h, w) of each pixel's neighbourhood, in the channel where it is largest."""
    box = (size, size, 1)
    return (maximum_filter(picture.astype(np.int16), box) - minimum_filter(picture.astype(np.int16), box)).max(axis=2)


def _solved(numbers: Numbers, start: np.ndarray, wanted: np.ndarray, chosen: np.ndarray, block: int):
    """SciPy's answer for the blocks `chosen`, whose levels are `wanted` (n, 3)."""
    recorded = Renderer(numbers.scene(start), METHOD)
    step, jump = (STRIDE * block, math.inf) if block > 1 else (STEP, JUMP)

    def residuals(values) -> np.ndarray:
        try:
            scene = numbers.scene(values)
        except InputError:  # numbers that no scene may have, e.g. a negative radius: the solver turns back
            return np.full(wanted.size, 255.0)
        if block > 1:
            scene = scene.resized(scene.camera.width // block, scene.camera.height // block, SAMPLES)
        found = 255 * np.nan_to_num(colors(scene, chosen, recorded)).clip(0, 1)
        return (found - wanted).ravel()

    def jacobian(values) -> np.ndarray:
        here, columns = residuals(values), []
        for k, value in enumerate(values):
            moved = values.copy()
            moved[k] += step * max(1, abs(value))
            columns.append((residuals(moved) - here) / (moved[k] - value))
        return np.where(np.abs(columns) < jump / step, columns, 0).T

    return least_squares(residuals, start, jacobian, loss="soft_l1", f_scale=1.0, x_scale="jac", max_nfev=20, ftol=1e-6)
